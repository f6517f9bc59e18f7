"""Tables of both programs: differences, modes, unstable pairs, times."""

from itertools import zip_longest
from typing import Any

from comparisons.kit.numbers import decimals, number, shown
from comparisons.kit.tables import Column, Data, Table

_MEGA = 1e6


def label(problem: Data) -> str:
    """A problem as tables name it."""
    return f"{problem['name']}, mesh {problem['mesh']}"


def apart(problem: Data, ours: str = "ours") -> float:
    """Worst relative difference of the frequencies of both programs."""
    return max(abs(mode[ours] / mode["frequency"] - 1) for mode in problem["modes"])


def differences_table(data: Data) -> Table:
    """A row for each problem: how far the frequencies of both programs are apart."""
    return Table(
        "differences",
        "Worst relative difference of the first frequencies, with the mass of CalculiX and with "
        "the exact one in this program; part of the area of the contact that CalculiX leaves out.",
        (
            Column("problem", "problem"),
            Column("dofs", "dofs", number),
            Column("modes", "modes", number),
            Column("same_mass", "same mass", shown(2)),
            Column("exact_mass", "exact mass", shown(2)),
            Column("area", "area left out", shown(2)),
        ),
        [
            (
                label(problem),
                problem["dofs"],
                len(problem["modes"]),
                apart(problem),
                apart(problem, "exact_mass"),
                problem["area"] and problem["area"]["meshed"] / problem["area"]["CalculiX"] - 1,
            )
            for problem in data["problems"]
        ],
    )


def unstable_table(data: Data) -> Table:
    """A row for each unstable mode of the problems in contact."""
    programs = ("CalculiX", "this program", "exact mass")
    rows: list[tuple[Any, ...]] = []
    for problem in data["problems"]:
        lists = [problem["unstable"][program] for program in programs]
        for modes in zip_longest(*lists, fillvalue={"frequency": None, "growth": None}):
            numbers = [mode[name] for mode in modes for name in ("frequency", "growth")]
            rows.append((label(problem), *numbers))
    return Table(
        "unstable",
        "Unstable modes, frequency and growth rate: of CalculiX, of this program with the mass of "
        "CalculiX, and with the exact mass.",
        (
            Column("problem", "problem"),
            *(
                Column(f"{name}_{what}", title, decimals(3), unit)
                for name, title in (("calculix", "CalculiX"), ("ours", "ours"), ("exact", "exact"))
                for what, unit in (("frequency", "Hz"), ("growth", "1/s"))
            ),
        ),
        rows,
    )


def times_table(data: Data) -> Table:
    """A row for each program on each problem."""
    rows = []
    for problem in data["problems"]:
        first = problem["runs"][0]["processor"]
        rows += [
            (
                label(problem),
                problem["dofs"],
                run["program"],
                run["clock"],
                run["processor"],
                run["processor"] / first,
                run["solver"],
                run["memory"] / _MEGA,
            )
            for run in problem["runs"]
        ]
    return Table(
        "times",
        "Whole processes on one thread: by the clock, of the processor, over that of CalculiX; "
        "what the program says its own work took by the clock; largest memory.",
        (
            Column("problem", "problem"),
            Column("dofs", "dofs", number),
            Column("program", "program"),
            Column("clock", "clock", shown(3), "s"),
            Column("processor", "processor", shown(3), "s"),
            Column("ratio", "ratio", shown(2)),
            Column("solver", "own work", shown(3), "s"),
            Column("memory", "memory", shown(3), "MB"),
        ),
        rows,
    )


def modes_table(data: Data) -> Table:
    """A row for each mode of each problem."""
    rows = [
        (
            label(problem),
            rank,
            mode["frequency"],
            mode["ours"],
            mode["ours"] / mode["frequency"] - 1,
            mode["exact_mass"],
            mode["growth"],
            mode["our_growth"],
        )
        for problem in data["problems"]
        for rank, mode in enumerate(problem["modes"], start=1)
    ]
    return Table(
        "modes",
        "Every mode by rising frequency; of a pair, the mode that decays comes first.",
        (
            Column("problem", "problem"),
            Column("mode", "mode", number),
            Column("calculix", "CalculiX", decimals(4), "Hz"),
            Column("ours", "ours", decimals(4), "Hz"),
            Column("apart", "apart", shown(2, sign=True)),
            Column("exact_mass", "exact mass", decimals(4), "Hz"),
            Column("growth", "growth", decimals(4), "1/s"),
            Column("our_growth", "ours", decimals(4), "1/s"),
        ),
        rows,
    )
