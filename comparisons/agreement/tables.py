"""Tables of a comparison: what was computed, with its errors, and what it cost."""

from collections.abc import Iterator
from math import tau
from typing import Any

from cea.contact.formulations import registered
from cea.timing import STAGES
from comparisons.kit import provenance
from comparisons.kit.numbers import decimals, number, per_cent, shown
from comparisons.kit.tables import Column, Data, Table
from scenes.names import backend_name

SECTIONS = {
    "patch_test": "patch test",
    "disc_pad": "disc and pad",
    "disc_alone": "disc alone",
}
"""Parts of a comparison that hold runs, by the name shown."""


_BACKEND = Column("backend", "backend", backend_name)
_FORMULATION = Column("formulation", "formulation")
_P = Column("P", "P", shown(1), "N/m")
_DOFS = Column("dofs", "dofs", number)
_SECONDS = Column("seconds", "run time", shown(3), "s")


def patch_test(data: Data) -> Table:
    """Oscillation of the normal stress of both sides, and what was expected."""
    rows = []
    for run in data["patch_test"]["runs"]:
        a, b = (run["stresses"]["interface"][side]["oscillation"] for side in "ab")
        worse, expected = run["oscillation"], run["expected"]
        ratio = worse / expected if expected else None
        labels = (run["backend"], run["formulation"], run["points"], run["P"])
        rows.append((*labels, a, b, worse, expected, ratio))
    return Table(
        "patch_test",
        "Oscillation of σₙ, largest minus smallest over the whole contact surface of a side. "
        "“Expected” is the oscillation on the worse side found by an independent prototype, "
        "where it was run.",
        (
            _BACKEND,
            _FORMULATION,
            Column("points", "points", number),
            _P,
            Column("oscillation_a", "side a", shown(3), "N/m²"),
            Column("oscillation_b", "side b", shown(3), "N/m²"),
            Column("oscillation", "worse", shown(4), "N/m²"),
            Column("expected", "expected", shown(4), "N/m²"),
            Column("ratio", "worse / expected", shown(4)),
        ),
        rows,
    )


def patch_stresses(data: Data) -> Table:
    """Normal stress along the diagonal of the contact surface."""
    rows = [
        (run["backend"], run["formulation"], run["P"], side, arc, stress)
        for run in data["patch_test"]["runs"]
        for side, sampled in run["stresses"]["interface"].items()
        for arc, stress in zip(sampled["arc"], sampled["sigma_n_along"], strict=True)
    ]
    names = ("backend", "formulation", "P", "side", "arc", "sigma_n")
    return Table("patch_stresses", "", tuple(Column(n, n) for n in names), rows)


def eigenvalues(data: Data) -> Table:
    """Every eigenvalue of the disc and pad with its errors."""
    rows = []
    for run in data["disc_pad"]["runs"]:
        unstable = {mode["mode"] for mode in run["unstable"]}
        for i, value in enumerate(run["eigenvalues"], start=1):
            numbers = (value["im"] / tau, value["re"], value["residual"], value["condition"])
            rows.append((run["backend"], run["formulation"], i, *numbers, i in unstable))
    names = ("backend", "formulation", "mode", "frequency", "growth", "residual", "condition")
    columns = tuple(Column(name, name) for name in (*names, "unstable"))
    return Table("eigenvalues", "", columns, rows)


def unstable_modes(data: Data) -> Table:
    """Unstable modes of the disc and pad."""
    return Table(
        "unstable_modes",
        "Unstable modes: those whose growth rate exceeds the threshold of the scene and what "
        "backward error times condition can explain.",
        (
            _BACKEND,
            _FORMULATION,
            Column("mode", "mode", number),
            Column("frequency", "frequency", decimals(2), "Hz"),
            Column("growth", "growth rate", decimals(2, sign=True), "1/s"),
            Column("residual", "residual", shown(2)),
            Column("condition", "condition", shown(3)),
        ),
        [row[:-1] for row in eigenvalues(data).rows if row[-1]],
    )


def kind_name(kind: str) -> str:
    """Name of a formulation by its method; "collocation" stands for each backend's own."""
    return registered()[kind].name if kind in registered() else kind


def agreement(data: Data) -> Table:
    """Unstable modes of the two backends paired by shape and frequency."""
    rows: list[tuple[Any, ...]] = []
    for kind, found in data["disc_pad"]["agreement"].items():
        label = kind_name(kind)
        matched = [
            (
                *(label, "both", *pair["frequency"], pair["frequency_difference"]),
                *(*pair["growth"], pair["growth_difference"], pair["modal_assurance"]),
            )
            for pair in found["pairs"]
        ]
        matched += [
            (label, "finite elements only", m["frequency"], None, None, m["growth"], *[None] * 3)
            for m in found["only_first"]
        ]
        matched += [
            (label, "NURBS only", None, m["frequency"], None, None, m["growth"], *[None] * 2)
            for m in found["only_second"]
        ]
        rows += sorted(matched, key=lambda row: row[2] or row[3])
    return Table(
        "agreement",
        "Unstable modes of the two backends, paired by shape and frequency over all modes "
        "together. Differences are those of finite elements relative to NURBS; MAC is the modal "
        "assurance of the two shapes on the contact surfaces, 1 where they are equal.",
        (
            _FORMULATION,
            Column("found_by", "found by"),
            Column("frequency_fe", "f, FE", decimals(2), "Hz"),
            Column("frequency_iga", "f, NURBS", decimals(2), "Hz"),
            Column("frequency_difference", "Δf", per_cent, "%"),
            Column("growth_fe", "growth, FE", decimals(2, sign=True), "1/s"),
            Column("growth_iga", "growth, NURBS", decimals(2, sign=True), "1/s"),
            Column("growth_difference", "Δ growth", per_cent, "%"),
            Column("modal_assurance", "MAC", decimals(4)),
        ),
        rows,
    )


def windows(data: Data) -> Table:
    """What was searched for eigenvalues, and the errors of what was found."""
    rows = []
    for run in data["disc_pad"]["runs"]:
        window, values = run["window"], run["eigenvalues"]
        contacts = run["contacts"].values()
        rows.append(
            (
                *(run["backend"], run["formulation"], run["dofs"]["free"]),
                *(run["points"], sum(contact["status"]["missed"] for contact in contacts)),
                *(len(values), window["found"], window["discs"]),
                "yes" if window["complete"] else "no",
                None if window["complete"] else window["max_growth"],
                max((value["residual"] for value in values), default=None),
                max((value["condition"] for value in values), default=None),
            )
        )
    return Table(
        "windows",
        "What was searched: eigenvalues κ found in discs that cover the window. It is complete "
        "where the field of values shows that none lies outside of them; otherwise modes may "
        "grow faster than is covered. The last columns are the largest of all modes of a run.",
        (
            _BACKEND,
            _FORMULATION,
            _DOFS,
            Column("points", "points", number),
            Column("missed", "missed", number),
            Column("modes", "modes", number),
            Column("found", "found", number),
            Column("discs", "discs", number),
            Column("complete", "complete"),
            Column("max_growth", "growth covered", shown(3), "1/s"),
            Column("largest_residual", "residual", shown(2)),
            Column("largest_condition", "condition", shown(3)),
        ),
        rows,
    )


def disc_alone(data: Data) -> Table:
    """Errors of the frequencies of the disc alone against run time and dofs."""
    part = data["disc_alone"]
    return Table(
        "disc_alone",
        f"Errors |f / f_ref − 1| of the first {part['modes']} frequencies of the disc without pad.",
        (
            Column("line", "method"),
            Column("mesh", "mesh"),
            _DOFS,
            _SECONDS,
            Column("median_error", "median error", shown(2)),
            Column("worst_error", "worst error", shown(2)),
        ),
        [
            (run["line"], run["mesh"], run["dofs"]["free"], *(run[k] for k in _ERROR_KEYS))
            for run in part["runs"]
        ],
    )


_ERROR_KEYS = ("seconds", "median_error", "worst_error")


def backend_differences(data: Data) -> Table:
    """Differences between both backends on the graded meshes of the disc alone."""
    keys = ("fe", "fe_seconds", "iga", "iga_seconds", "median", "worst")
    return Table(
        "backend_differences",
        "Relative differences |f_fe / f_nurbs − 1| of the same frequencies between the graded "
        "meshes of both backends: hexahedra of degree 2 and NURBS of degree 3.",
        (
            Column("fe", "hexahedra"),
            Column("fe_seconds", "time", shown(3), "s"),
            Column("iga", "NURBS"),
            Column("iga_seconds", "time", shown(3), "s"),
            Column("median", "median difference", shown(2)),
            Column("worst", "worst difference", shown(2)),
        ),
        [tuple(item[k] for k in keys) for item in data["disc_alone"]["backend_differences"]],
    )


def disc_frequencies(data: Data) -> Table:
    """Frequencies of the disc alone beside the reference."""
    reference = data["disc_alone"]["reference"]
    rows = [
        (run["line"], run["mesh"], i + 1, frequency, exact)
        for run in data["disc_alone"]["runs"]
        for i, (frequency, exact) in enumerate(
            zip(run["frequencies"], reference["frequencies"], strict=True)
        )
    ]
    names = ("line", "mesh", "mode", "frequency", "reference")
    return Table("disc_frequencies", "", tuple(Column(name, name) for name in names), rows)


def runs(data: Data) -> Iterator[tuple[str, str, Data]]:
    """Every run: name of its section, its label, its data."""
    for run in data["patch_test"]["runs"]:
        label = f"{backend_name(run['backend'])}, {run['formulation']}, P = {number(run['P'], 1)}"
        yield SECTIONS["patch_test"], label, run
    for run in data["disc_pad"]["runs"]:
        label = f"{backend_name(run['backend'])}, {run['formulation']}"
        yield SECTIONS["disc_pad"], label, run
    for run in (data["disc_alone"]["reference"], *data["disc_alone"]["runs"]):
        yield SECTIONS["disc_alone"], f"{run['line']}, {run['mesh']}", run


def stage_times(data: Data) -> Table:
    """Seconds of every run by stage."""
    timed = [(section, label, run["timings"], run["seconds"]) for section, label, run in runs(data)]
    stages = [*STAGES, *sorted({s for *_, timings, _ in timed for s in timings} - set(STAGES))]
    return Table(
        "stage_times",
        "Wall-clock seconds of every run by stage.",
        (
            Column("section", "part"),
            Column("run", "run"),
            *(Column(s, s.replace("krylov", "Krylov"), decimals(2), "s") for s in stages),
            Column("total", "total", decimals(2), "s"),
        ),
        [
            (section, label, *(timings.get(stage, 0.0) for stage in stages), total)
            for section, label, timings, total in timed
        ],
    )


def time_saved(data: Data) -> Table:
    """Processor seconds of one scene with and without what it does not need."""
    saved = data["time_saved"]
    lean, full = saved["lean"], saved["full"]
    rows = [(stage, lean.get(stage, 0.0), full.get(stage, 0.0)) for stage in {**full, **lean}]
    rows.append(("total", saved["lean_seconds"], saved["full_seconds"]))
    seconds = decimals(2)
    return Table(
        "time_saved",
        f"{saved['scene']}: processor seconds solved as it is, and as if nothing could be left "
        f"out; medians of {number(saved['pairs'])} runs each, the total that of whole runs.",
        (
            Column("stage", "stage"),
            Column("lean", "left out", seconds, "s"),
            Column("full", "kept", seconds, "s"),
            Column("saved", "saved", seconds, "s"),
        ),
        [(stage, left_out, kept, kept - left_out) for stage, left_out, kept in rows],
    )


def skipped(data: Data) -> Table:
    """What the runs of each part did not need, with the reason."""
    return provenance.skipped(runs(data))


def parameters(data: Data) -> Table:
    """Parameters of the scenes as run."""
    return provenance.parameters(runs(data))
