"""Tables of the pairings of backends: every run, and the modes of each beside another's."""

from collections.abc import Iterator
from typing import Any

from comparisons.kit.numbers import decimals, number, per_cent, plain, shown
from comparisons.kit.tables import VERDICTS, Column, Data, Table
from scenes.names import backend_name


def pairing_name(run: Data) -> str:
    """Backends of pad and disc."""
    return f"{backend_name(run['pad'])} on {backend_name(run['disc'])}"


def pairing_runs(data: Data) -> Table:
    """Size, window and unstable modes of every run of the disc and pad."""
    part = data["pairings"]
    return Table(
        "pairing_runs",
        f"Runs up to {plain(part['max_frequency'] / 1000)} kHz. Found: eigenvalues below the end "
        "of the window; counted: those that the inertia of the symmetric part has there. Unstable: "
        f"growth above {plain(part['growth_threshold'])} 1/s.",
        (
            Column("run", "pad on disc"),
            Column("dofs", "dofs", number),
            Column("found", "found", number),
            Column("counted", "counted", number),
            Column("unstable", "unstable", number),
            Column("condition", "largest condition", shown(2)),
            Column("seconds", "run time", shown(3), "s"),
        ),
        [
            (
                *(label, run["dofs"], run["window"]["found_below"]),
                *(run["window"]["symmetric_count"], len(run["unstable"])),
                max((mode["condition"] for mode in run["unstable"]), default=None),
                run["seconds"],
            )
            for label, run in _labelled_runs(part)
        ],
    )


def pairing_differences(data: Data) -> Table:
    """Every unstable mode of each run beside its partner in the run it is compared with."""
    part = data["pairings"]
    bounds = part["bounds"]
    first, *others = part["runs"]
    rows = [
        row
        for run, found in zip(others, part["differences"], strict=True)
        for row in _differences(
            f"{pairing_name(run)}, against {pairing_name(first)}", found, bounds
        )
    ]
    rows += _differences(
        f"{refined_name(part)}, against the degree of the scene",
        part["refined"]["difference"],
        bounds,
    )
    return Table(
        "pairing_differences",
        "Unstable modes paired by shape and eigenvalue: those compared with, those compared, and "
        "the change from the first to the second. Within: at most "
        f"{plain(100 * bounds['frequency'])} % in frequency and "
        f"{plain(100 * bounds['growth'])} % in growth rate.",
        (
            Column("section", "compared"),
            Column("frequency_first", "frequency", decimals(2), "Hz"),
            Column("frequency", "compared", decimals(2), "Hz"),
            Column("frequency_change", "change", per_cent, "%"),
            Column("growth_first", "growth rate", decimals(2), "1/s"),
            Column("growth", "compared", decimals(2), "1/s"),
            Column("growth_change", "change", per_cent, "%"),
            Column("modal_assurance", "modal assurance", decimals(4)),
            Column("within", "within", VERDICTS.__getitem__),
        ),
        rows,
    )


def within(pair: Data, bounds: Data) -> bool:
    """Whether a pair of modes agrees."""
    return all(abs(change(pair, key)) <= bounds[key] for key in ("frequency", "growth"))


def change(pair: Data, key: str) -> float:
    """Relative change of ``frequency`` or ``growth`` from the first of a pair to the second."""
    first, second = pair[key]
    return second / first - 1


def refined_name(part: Data) -> str:
    """Name of the run of higher degree."""
    return f"{pairing_name(part['refined'])}, degree {part['study']['refined_degree']}"


def _labelled_runs(part: Data) -> Iterator[tuple[str, Data]]:
    yield from ((pairing_name(run), run) for run in part["runs"])
    yield refined_name(part), part["refined"]


def _differences(section: str, found: Data, bounds: Data) -> Iterator[tuple[Any, ...]]:
    for pair in found["pairs"]:
        yield (
            *(section, *pair["frequency"], change(pair, "frequency")),
            *(*pair["growth"], change(pair, "growth")),
            *(pair["modal_assurance"], within(pair, bounds)),
        )
    for mode in found["only_first"]:
        yield section, mode["frequency"], None, None, mode["growth"], None, None, None, False
    for mode in found["only_second"]:
        yield section, None, mode["frequency"], None, None, mode["growth"], None, None, False
