"""Sentences of the report, each computed from the data it speaks of."""

from collections.abc import Mapping, Sequence
from typing import Any

from comparisons.agreement.tables import SECTIONS, kind_name, runs
from comparisons.kit.numbers import (
    capitalised,
    counted,
    decimals,
    listed,
    number,
    plain,
)
from comparisons.kit.tables import Data
from scenes.names import backend_name


def findings(data: Data) -> list[tuple[str, str]]:
    """What was found, a sentence or two for each section of the page, and the section."""
    return [
        ("pad", agreement(data)),
        ("patch", patch_test(data)),
        ("disc", disc_alone(data)),
        ("left-out", saved(data)),
        ("times", total(data)),
    ]


def summary(data: Data) -> str:
    """The findings in one paragraph."""
    return " ".join(sentence for _, sentence in findings(data))


def agreement(data: Data) -> str:
    """How many unstable modes each backend finds with GPTS, and how far they are apart."""
    return " ".join(_agreement(data))


def patch_test(data: Data) -> str:
    """The range of oscillations, and the worst ratio to what was expected."""
    return " ".join(_patch_test(data))


def _agreement(data: Data) -> list[str]:
    """How many unstable modes each backend finds with GPTS, and how far they are apart."""
    found = data["disc_pad"]["agreement"]["gpts"]
    pairs, alone = found["pairs"], (found["only_first"], found["only_second"])
    counts = [len(pairs) + len(modes) for modes in alone]
    scene = data["disc_pad"]["runs"][0]["scene"]
    top = scene["analysis"]["max_frequency"]
    sentences = [
        f"With GPTS the disc and pad have {counted(counts[0], 'unstable mode')} up to "
        f"{plain(top / 1000)} kHz on finite elements and {number(counts[1])} on NURBS."
    ]
    if pairs:
        f, g = (max(abs(p[f"{k}_difference"]) for p in pairs) for k in ("frequency", "growth"))
        least = min(pair["modal_assurance"] for pair in pairs)
        sentences.append(
            f"{counted(len(pairs), 'pair')} of them can be formed; the largest difference is "
            f"{number(100 * f, 2)} % in frequency and {number(100 * g, 2)} % in growth rate, the "
            f"least modal assurance {decimals(4)(least)}."
        )
    for backend, modes in zip(("fe", "iga"), alone, strict=True):
        if modes:
            places = listed(f"{mode['frequency']:.0f} Hz" for mode in modes)
            sentences.append(f"{capitalised(backend_name(backend))} alone find one at {places}.")
    return sentences


def lone_modes(data: Data) -> list[str]:
    """Unstable modes without partner so near the end of the window that it may lie beyond."""
    top = data["disc_pad"]["runs"][0]["scene"]["analysis"]["max_frequency"]
    sentences = []
    for kind, found in data["disc_pad"]["agreement"].items():
        apart = max((abs(pair["frequency_difference"]) for pair in found["pairs"]), default=0.0)
        alone = [("fe", mode["frequency"]) for mode in found["only_first"]]
        alone += [("iga", mode["frequency"]) for mode in found["only_second"]]
        sentences += [
            f"The mode that {backend_name(backend)} alone find with {kind_name(kind)} at "
            f"{frequency:.0f} Hz is {number(100 * (1 - frequency / top), 2)} % below the end of "
            f"the window, less than paired modes are apart ({number(100 * apart, 2)} % at most): "
            f"its partner may lie beyond."
            for backend, frequency in alone
            if 1 - frequency / top <= apart
        ]
    return sentences


def _patch_test(data: Data) -> list[str]:
    """The range of oscillations, and the worst ratio to what was expected."""
    tested = sorted(data["patch_test"]["runs"], key=lambda run: run["oscillation"])
    ends = [
        f"{number(run['oscillation'])} N/m² ({backend_name(run['backend'])}, {run['formulation']}, "
        f"P = {number(run['P'], 1)} N/m)"
        for run in (tested[0], tested[-1])
    ]
    sentences = [f"In the patch test σₙ oscillates by {ends[0]} to {ends[1]}."]
    ratios = [run["oscillation"] / run["expected"] for run in tested if run["expected"]]
    if ratios:
        worst = max(ratios, key=lambda ratio: max(ratio, 1 / ratio))
        sentences.append(
            f"Of {counted(len(ratios), 'oscillation')} with an expected value the worst is "
            f"{number(worst, 4)} times what was expected."
        )
    return sentences


def disc_alone(data: Data) -> str:
    """The most accurate run of each backend."""
    part = data["disc_alone"]
    best = []
    for backend in dict.fromkeys(run["backend"] for run in part["runs"]):
        own = [run for run in part["runs"] if run["backend"] == backend]
        run = min(own, key=lambda run: run["worst_error"])
        best.append(
            f"{number(run['worst_error'], 2)} in {number(run['seconds'], 2)} s "
            f"({run['line']}, {run['mesh']})"
        )
    return (
        f"The worst error of the first {part['modes']} frequencies of the disc alone is at best "
        f"{listed(best)}."
    )


def saved(data: Data) -> str:
    """What leaving friction out saves, where that is more than equal runs are apart."""
    saved = data["time_saved"]
    ratio, noise = saved["ratio"], f"{number(100 * saved['noise'], 2)} %"
    pairs = f"median of {number(saved['pairs'])} pairs of runs"
    if abs(1 - ratio["median"]) <= saved["noise"]:
        return (
            f"Whether leaving out what a scene without friction does not need saves processor time "
            f"cannot be told: it takes {_changed(ratio['median'])} ({pairs}), and equal runs are "
            f"up to {noise} apart."
        )
    return (
        f"Leaving out what a scene without friction does not need takes {_changed(ratio['median'])}"
        f" processor time ({pairs}, {_changed(ratio['largest'])} to {_changed(ratio['least'])}); "
        f"equal runs are up to {noise} apart."
    )


def _changed(ratio: float) -> str:
    return f"{number(100 * abs(1 - ratio), 2)} % {'less' if ratio <= 1 else 'more'}"


def total(data: Data) -> str:
    """How long everything took."""
    return f"All runs together took {number(data['seconds'])} s."


def reference(data: Data) -> str:
    """What the errors of the disc alone are relative to."""
    run = data["disc_alone"]["reference"]
    mesh = run["scene"]["bodies"]["disc"]["mesh"][run["backend"]]
    finest = max(item["dofs"]["free"] for item in data["disc_alone"]["runs"])
    return (
        f"Reference: {backend_name(run['backend'])}, degree {plain(mesh['degree'])}, "
        f"{run['mesh']} elements, {number(run['dofs']['free'])} dofs, {number(run['seconds'])} s; "
        f"the largest mesh compared with it has {number(finest)} dofs. Errors are relative to its "
        f"frequencies and mean no more than these."
    )


def evidence(data: Data) -> list[tuple[str, str]]:
    """Label of each run of the disc and pad, and why its window is believed complete."""
    return [
        (label, run["window"]["evidence"])
        for section, label, run in runs(data)
        if section == SECTIONS["disc_pad"]
    ]


def errors_of_modes(data: Data) -> str:
    """Largest residual and condition number over all modes of the disc and pad."""
    modes = [(run, value) for _, _, run in runs(data) if "method" in run for value in _values(run)]
    if not modes:
        return "No mode was found."
    residual = max(modes, key=lambda item: item[1]["residual"])
    condition = max(modes, key=lambda item: item[1]["condition"])
    return (
        f"The largest residual of all modes is {number(residual[1]['residual'], 2)} "
        f"({_run(residual[0])}), the largest condition number "
        f"{number(condition[1]['condition'])} ({_run(condition[0])})."
    )


def warned(data: Data) -> list[str]:
    """What runs warn of, each kind once."""
    return [f"{capitalised(warning['message'])}." for warning in data["warnings"]]


def kept_bodies(data: Data) -> str:
    """How many runs used bodies, and matrices, that an earlier run had built."""
    everything = [run for _, _, run in runs(data)]
    kept = sum(run["timings"]["meshing"] == 0 for run in everything)
    return (
        f"{counted(kept, 'run')} of {number(len(everything))} took bodies an earlier run had "
        f"built, and were charged for no meshing."
    )


def missed_points(data: Data) -> str:
    """How many contact points found nothing on the opposite side."""
    statuses = [c["status"] for _, _, run in runs(data) for c in run["contacts"].values()]
    total = sum(sum(status.values()) for status in statuses)
    missed = sum(status["missed"] for status in statuses)
    return (
        f"{number(missed)} of {counted(total, 'contact point')}, over all runs, found nothing on "
        f"the opposite side."
    )


def descriptions(data: Data) -> dict[str, str]:
    """Description of the scene of each part, by the part's name."""
    found: dict[str, str] = {}
    for section, _, run in runs(data):
        if text := run["scene"].get("description"):
            found.setdefault(section, " ".join(text.split()))
    return found


def _values(run: Data) -> Sequence[Mapping[str, Any]]:
    return run.get("eigenvalues", ())


def _run(run: Data) -> str:
    return f"{backend_name(run['backend'])}, {run['formulation']}"
