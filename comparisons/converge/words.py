"""What a record says, in sentences."""

from cea.eigen.classify import counted_words
from comparisons.converge.tables import SINGULAR_RATE, degree_text, elements_text
from comparisons.kit.numbers import capitalised, counted, listed, number
from comparisons.kit.tables import Data
from scenes.names import backend_name


def verdict(data: Data) -> str:
    """How many modes have which word, with their error bars."""
    words = [mode["verdict"] for mode in data["modes"]]
    growth = [mode["growth"] for mode in data["modes"]]
    up_to = f"{number(data['max_frequency'])} Hz"
    if not data["levels"]:
        return f"No mesh was solved: nothing is known of modes up to {up_to}."
    if not words:
        return f"No modes below {up_to}."
    counts = counted_words(words, growth, data.get("growth_threshold"))
    return f"{capitalised(counted(len(words), 'mode'))} up to {up_to}: {counts}."


def held(data: Data) -> list[str]:
    """For each backend whether the digits are held, and what more would cost."""
    return [_of_backend(data, backend, of) for backend, of in data["backends"].items()]


def _of_backend(data: Data, backend: str, of: Data) -> str:
    digits = data["inputs"]["digits"]
    growth = data["inputs"]["growth_digits"]
    asked = f"{counted(digits, 'digit')} of frequency"
    asked += f", {growth or max(1, digits - 1)} of growth"
    own = [level for level in data["levels"] if level["backend"] == backend]
    meshes = sum(not level["corrected"] for level in own)
    after = counted(meshes, "mesh", "meshes")
    if len(own) > meshes:
        after += ", the last one corrected in a richer space"
    if of["held"]:
        said = f"{asked} held after {after}"
    else:
        said = f"{asked} not held after {after}: {of['ended']}"
        if of["need"] is not None:
            said += f"; the largest bar is {number(of['need'], 2)} times too large"
    more = of["more"]
    cost = (
        f" A digit more is expected to cost {number(more['seconds'], 2)} s: degree "
        f"{degree_text(more)}, {elements_text(more['elements'])}."
        if more
        else " No mesh that is within reach in one step is expected to give a digit more."
    )
    return f"{capitalised(backend_name(backend))}: {said}.{cost}"


def mortar(data: Data) -> list[str]:
    """Contacts whose formulation was changed."""
    if not data["mortar"]:
        return []
    named = listed(f"{name} ({method})" for name, method in data["mortar"].items())
    return [f"Contacts are mortar here, whose error is that of the meshes; the scene has {named}."]


def singular(data: Data) -> str:
    """Which modes converge as singular ones do."""
    found = [
        str(i)
        for i, mode in enumerate(data["modes"], 1)
        if mode["rate"] is not None and mode["rate"] < SINGULAR_RATE
    ]
    unseen = sum(mode["rate"] is None and not mode["rigid"] for mode in data["modes"])
    said = f"Singular modes: {listed(found)}." if found else "No mode is seen to be singular."
    if unseen:
        said += f" No order is seen in {counted(unseen, 'mode')}."
    return said


def rigid(data: Data) -> list[str]:
    """Motions that nothing holds."""
    found = [str(i) for i, mode in enumerate(data["modes"], 1) if mode["rigid"]]
    if not found:
        return []
    said = f"{'Modes' if found[1:] else 'Mode'} {listed(found)}: rigid motion that nothing holds, "
    return [f"{said}lambda = 0 on every mesh but for rounding. No digits are asked of it."]


def lost(data: Data) -> list[str]:
    """Modes that were lost between meshes, or changed in number."""
    said = [
        f"{backend_name(mode['backend'])}: a mode of the last mesh but one, near "
        f"{number(mode['frequency'], 5)} Hz, is not among those of the last."
        for mode in data["lost"]
    ]
    changed = [str(i) for i, mode in enumerate(data["modes"], 1) if mode["changed"]]
    if changed:
        said.append(
            f"Modes {listed(changed)} stood for another number of modes on some mesh, which their "
            "bars leave out."
        )
    return said


def for_sweeps(data: Data) -> str:
    """Which mesh is written for sweeps."""
    digits = data["inputs"]["sweep_digits"]
    if "for_sweeps" not in data["scenes"]:
        return f"No mesh tried holds {counted(digits, 'digit')} of lambda in every mode."
    tolerance = 0.5 * 10.0**-digits
    best = min(
        (
            e
            for e in data["levels"]
            if e["bound"] is not None and e["bound"] <= tolerance and not e["corrected"]
        ),
        key=lambda level: float(level["seconds"]),
    )
    return (
        f"for_sweeps.toml holds {counted(digits, 'digit')} of lambda in every mode: "
        f"{backend_name(best['backend'])}, degree {degree_text(best)}, "
        f"{elements_text(best['elements'])}, {number(best['seconds'], 2)} s a run."
    )
