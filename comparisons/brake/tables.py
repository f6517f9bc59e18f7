"""Tables of the brake: what each mesh cost, every mode over the meshes, what is unstable."""

from collections.abc import Iterator
from itertools import pairwise
from math import hypot, isclose, tau
from statistics import fmean
from typing import Any

from comparisons.kit.numbers import decimals, number, per_cent, plain, shown
from comparisons.kit.tables import VERDICTS, Column, Data, Table

Mode = dict[str, Any]

_PARTNERS = 1e-10
"""Relative distance of the frequencies of a growing mode and its decaying partner."""


def damping_ratio(mode: Data) -> float:
    """- Re lambda / abs(lambda): negative where a mode grows."""
    growth = float(mode["growth"])
    return -growth / hypot(growth, tau * mode["frequency"]) if growth else 0.0


def unstable_modes(run: Data) -> list[Mode]:
    """Unstable modes of a run: the growing one of each pair."""
    return [mode for mode in run["modes"] if mode["verdict"] == "unstable"]


def runs_table(data: Data) -> Table:
    """What each mesh gave and took."""
    columns = (
        Column("size", "size", shown(2), "mm"),
        Column("dofs", "dofs", number),
        Column("modes", "modes", number),
        Column("unstable", "unstable pairs", number),
        Column("complete", "complete"),
        Column("seconds", "time", decimals(0), "s"),
        Column("factorisation", "factors", decimals(0), "s"),
        Column("krylov", "Krylov", decimals(0), "s"),
        Column("memory", "memory", decimals(1), "GB"),
        Column("estimated", "estimated", decimals(1), "GB"),
    )
    rows = [
        (
            run["size"] * 1e3,
            run["dofs"],
            len(run["modes"]),
            len(unstable_modes(run)),
            VERDICTS[run["complete"]],
            run["seconds"],
            run["timings"]["factorisation"],
            run["timings"]["krylov"],
            run["memory"]["measured"] / 1e9,
            run["memory"]["estimated"] / 1e9,
        )
        for run in data["runs"]
    ]
    return Table("brake_runs", "ventilated_brake on each mesh.", columns, rows)


def modes_table(data: Data) -> Table:
    """Every mode of the finest mesh, or group of modes that nearly coalesce, over all meshes."""
    sizes = [run["size"] for run in data["runs"]]
    frequencies = tuple(
        Column(f"frequency_{size * 1e3:g}mm", f"{size * 1e3:g} mm", decimals(1), "Hz")
        for size in sizes
    )
    growths = tuple(
        Column(f"growth_{size * 1e3:g}mm", f"growth, {size * 1e3:g} mm", shown(3), "1/s")
        for size in sizes
    )
    columns = (
        Column("modes", "mode"),
        *frequencies,
        Column("spread", "spread", per_cent, "%"),
        *growths,
        Column("damping_ratio", "damping ratio", shown(2)),
        Column("verdict", "verdict"),
    )
    rows = []
    for members in _over_meshes(data):
        found = [
            [run["modes"][i] for i in numbers]
            for run, numbers in zip(data["runs"], members, strict=True)
        ]
        means = [fmean(m["frequency"] for m in each) if each else None for each in found]
        known = [mean for mean in means if mean is not None]
        fastest = [max(each, key=lambda m: m["growth"]) if each else None for each in found]
        last = fastest[-1]
        assert last is not None
        rows.append(
            (
                ", ".join(str(i + 1) for i in members[-1]),
                *means,
                (max(known) - min(known)) / known[-1] if len(known) > 1 else None,
                *(mode["growth"] if mode else None for mode in fastest),
                damping_ratio(last),
                last["verdict"],
            )
        )
    caption = (
        "Modes of the finest mesh and what they are on the others: means of modes that nearly "
        "coalesce, the largest of their growth rates."
    )
    return Table("brake_modes", caption, columns, rows)


def _over_meshes(data: Data) -> Iterator[list[list[int]]]:
    """Numbers of the modes on each mesh that stand for one another, by those of the finest.

    The growing and the decaying mode of a pair, which were one mode each before they met, stay
    together.
    """
    matches, modes = data["matches"], data["runs"][-1]["modes"]
    groups = [set(group["second"]) for group in matches[-1]["groups"]] if matches else []
    groups += [{i} for i in range(len(modes)) if not any(i in group for group in groups)]
    for i, j in pairwise(range(len(modes))):
        if isclose(modes[i]["frequency"], modes[j]["frequency"], rel_tol=_PARTNERS):
            together = [group for group in groups if group & {i, j}]
            groups = [group for group in groups if group not in together]
            groups.append(set().union(*together))
    for members in sorted(map(sorted, groups)):
        chain = [members]
        for match in reversed(matches):
            before = [g["first"] for g in match["groups"] if set(g["second"]) & set(chain[0])]
            chain.insert(0, sorted({i for first in before for i in first}))
        yield chain


def unstable_table(data: Data) -> Table:
    """Unstable pairs of every mesh, and of every stiffness on the coarsest."""
    first = data["runs"][0]
    others = [{**run, "size": first["size"]} for run in data["stiffnesses"]]
    runs = [*data["runs"], *(run for run in others if run["p"] != first["p"])]
    rows = [_unstable(run, mode) for run in runs for mode in unstable_modes(run)]
    columns = (
        Column("size", "size", shown(2), "mm"),
        Column("p", "p", plain, "N/m³"),
        Column("frequency", "frequency", decimals(1), "Hz"),
        Column("growth", "growth rate", shown(4), "1/s"),
        Column("damping_ratio", "damping ratio", shown(3)),
        Column("uncertainty", "algebraic error", shown(1), "1/s"),
    )
    return Table("brake_unstable", "Unstable pairs up to the end of the window.", columns, rows)


def _unstable(run: Data, mode: Data) -> tuple[Any, ...]:
    values = mode["frequency"], mode["growth"], damping_ratio(mode), mode["uncertainty"]
    return run["size"] * 1e3, run["p"], *values


def stiffness_table(data: Data) -> Table:
    """Runs on the coarsest mesh with other contact stiffnesses."""
    columns = (
        Column("p", "p", plain, "N/m³"),
        Column("modes", "modes", number),
        Column("unstable", "unstable pairs", number),
        Column("fastest", "fastest growth", shown(4), "1/s"),
        Column("at", "at", decimals(1), "Hz"),
        Column("complete", "complete"),
        Column("verdict", "verdict"),
    )
    rows = []
    for run in data["stiffnesses"]:
        unstable = unstable_modes(run)
        fastest = max(unstable, key=lambda m: m["growth"], default=None)
        rows.append(
            (
                run["p"],
                len(run["modes"]),
                len(unstable),
                fastest["growth"] if fastest else None,
                fastest["frequency"] if fastest else None,
                VERDICTS[run["complete"]],
                run["verdict"],
            )
        )
    return Table("brake_stiffness", "Contact stiffnesses, on the coarsest mesh.", columns, rows)
