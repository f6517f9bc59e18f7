"""Stiffness and mass of one body by this program and by dolfinx: processor time and memory.

Rounds repeat all cases by turns, and each round holds plain dolfinx with quadratic hexahedra, by
which the others are measured: what else the machine does then slows all of them alike.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from time import process_time
from typing import Any

import pandas as pd

from comparisons.bench.programs import Boxes, Discretisation, Family, Ours, PlainDolfinx
from comparisons.study.columns import Column, medians
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study, at_least_one

DEGREES: Mapping[Family, tuple[int, ...]] = {
    "NURBS": (2, 3, 4),
    "Q": (1, 2, 3, 4),
    "P": (1, 2, 3, 4),
}
"""Degrees of each family."""
OURS, PLAIN = "this program", "dolfinx"
YARDSTICK = ("Q2", PLAIN)
"""What every other is measured by."""
PROGRAMS: Mapping[str, type[Ours] | type[PlainDolfinx]] = {OURS: Ours, PLAIN: PlainDolfinx}
_BYTES = 12
"""Bytes of an entry of a compressed matrix: a double and the number of its column."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark.

    Parameters
    ----------
    boxes
        Elements along radius, angle and height.
    boxes_of_degree_4
        Those of Lagrange functions of degree 4, whose matrices are the largest.
    repeats
        Rounds; medians count.
    """

    boxes: Boxes = (16, 16, 8)
    boxes_of_degree_4: Boxes = (8, 8, 4)
    repeats: int = 3

    def __post_init__(self) -> None:
        at_least_one(repeats=self.repeats)
        for boxes in (self.boxes, self.boxes_of_degree_4):
            Discretisation("Q", 1, boxes)


def cases(options: Options) -> Iterator[Case]:
    """Every discretisation by every program that knows it, by turns."""
    for repeat in range(options.repeats):
        for family, degrees in DEGREES.items():
            for degree in degrees:
                for program in [OURS] if family == "NURBS" else PROGRAMS:
                    yield {"functions": f"{family}{degree}", "program": program, "repeat": repeat}


def discretisation(functions: str, options: Options) -> Discretisation:
    """The body divided for functions as ``Q2``."""
    degree = int(functions[-1])
    family: Any = functions[:-1]
    coarser = family != "NURBS" and degree == max(DEGREES[family])
    return Discretisation(family, degree, options.boxes_of_degree_4 if coarser else options.boxes)


@cache
def _warm_up(program: str, family: Family, degree: int) -> None:
    """Assemble the smallest body once in a process, to load and compile what it needs."""
    assembled(PROGRAMS[program](Discretisation(family, degree, (1, 1, 1))))


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Time and memory of an assembly."""
    divided = discretisation(case["functions"], session.options)
    _warm_up(case["program"], divided.family, divided.degree)
    row = {"family": divided.family, "degree": divided.degree, "elements": divided.elements}
    return row | assembled(PROGRAMS[case["program"]](divided))


def assembled(program: Ours | PlainDolfinx) -> dict[str, Any]:
    """Processor seconds of both matrices; peak memory above that before, and that finished (MB)."""
    with measured() as both:
        begun = process_time()
        K = program.stiffness()
        stiffness = process_time() - begun
        M = program.mass()
    return {
        "dofs": K.getSize()[0],
        "stiffness": stiffness,
        "mass": both.processor - stiffness,
        "memory": both.memory,
        "finished": _BYTES * sum(matrix.getInfo()["nz_used"] for matrix in (K, M)) / 1e6,
    }


def times(result: StudyResult) -> pd.DataFrame:
    """Medians of each program and discretisation; ratios are to the yardstick of the same round."""
    frame = result.frame()
    both = frame["stiffness"] + frame["mass"]
    element = both / frame["elements"]
    yardstick = element[(frame["functions"] == YARDSTICK[0]) & (frame["program"] == YARDSTICK[1])]
    unit = frame["repeat"].map(dict(zip(frame["repeat"][yardstick.index], yardstick, strict=True)))
    frame["per_element"], frame["per_dof"] = 1e3 * element, 1e6 * both / frame["dofs"]
    frame["ratio"], frame["memory_ratio"] = element / unit, frame["memory"] / frame["finished"]
    for name in ("stiffness", "mass"):
        frame[name] = 1e3 * frame[name] / frame["elements"]
    return medians(frame)


COLUMNS = {
    **{name: Column(name, "ms/element", shown(3)) for name in ("stiffness", "mass")},
    "per_element": Column("both", "ms/element", shown(3)),
    "per_dof": Column("both", "µs/dof", shown(3)),
    "ratio": Column("of dolfinx Q2", show=shown(3)),
    "memory_ratio": Column("peak memory / finished matrices", show=shown(3)),
    "finished": Column("finished", "MB", shown(3)),
}
TIMES = Table(
    "times",
    "Processor time of stiffness and mass on one thread, medians; an element over one of plain "
    "dolfinx Q2, assembled in the same round. Memory: peak while assembling above that before; "
    "finished: the matrices, 12 bytes an entry.",
    *(times, COLUMNS),
    printed=True,
)
STUDY = Study(
    name="bench assembly",
    title="Assembly of stiffness and mass beside dolfinx",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    quick={"boxes": (2, 2, 1), "boxes_of_degree_4": (1, 1, 1), "repeats": 1},
    process=Process("comparisons.bench.assembly:STUDY", 120.0),
    sections=[
        Section(
            "Assembly",
            "A quarter of a thick ring, divided alike everywhere.",
            of="runs",
            tables=[TIMES],
            plots=[
                Plot(
                    *(f"{name}_over_degree", caption, times, "degree", name),
                    *(("program",), "family", "y", COLUMNS),
                )
                for name, caption in (
                    ("ratio", "Time of an element against degree."),
                    ("memory_ratio", "Peak memory over that of the matrices."),
                )
            ],
        )
    ],
)
