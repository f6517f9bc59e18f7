"""Stiffness and mass of one body by several programs: processor time, memory, and what they give.

Every program runs in a process of its own on one thread. Rounds repeat all of them by turns, and
each round holds plain dolfinx with quadratic hexahedra, by which the others are measured: what else
the machine does then slows all of them alike, and ratios to it stay what they are.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from time import process_time
from typing import Any

import numpy as np
import pandas as pd

from cea.errors import InputError
from comparisons.bench.programs import (
    MATERIAL,
    Boxes,
    Discretisation,
    Family,
    MassOfVectors,
    Ours,
    PlainDolfinx,
    checked,
    matrices_of,
)
from comparisons.study.columns import Column, medians
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study

DEGREES: Mapping[Family, tuple[int, ...]] = {
    "NURBS": (2, 3, 4),
    "Q": (1, 2, 3, 4),
    "P": (1, 2, 3, 4),
}
"""Degrees of each family."""
OURS, PLAIN = "this program", "dolfinx"
YARDSTICK = ("Q2", PLAIN)
"""What every other is measured by."""
PROGRAMS: Mapping[str, type[Ours] | type[PlainDolfinx]] = {
    OURS: Ours,
    PLAIN: PlainDolfinx,
    "dolfinx, mass of vectors": MassOfVectors,
}
_BYTES = 12
"""Bytes of an entry of a compressed matrix: a double and the number of its column."""
_TINY: Boxes = (1, 1, 1)
"""A body on which a program is run once ahead of all, to load and compile what it needs."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark.

    Parameters
    ----------
    boxes
        Elements along radius, angle and height.
    boxes_of_degree_4
        Those of Lagrange functions of degree 4, whose matrices are the largest.
    checked_boxes
        Those on which eigenvalues are compared.
    modes
        Eigenvalues that are compared.
    repeats
        Rounds; medians count.
    """

    boxes: Boxes = (16, 16, 8)
    boxes_of_degree_4: Boxes = (8, 8, 4)
    checked_boxes: Boxes = (4, 4, 2)
    modes: int = 6
    repeats: int = 3

    def __post_init__(self) -> None:
        for name in ("repeats", "modes"):
            if getattr(self, name) < 1:
                raise InputError(name, getattr(self, name), "1 or more")
        for boxes in (self.boxes, self.boxes_of_degree_4, self.checked_boxes):
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
    assembled(PROGRAMS[program](Discretisation(family, degree, _TINY)))


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Time and memory of an assembly; in the first round also what the matrices give."""
    program, options = case["program"], session.options
    divided = discretisation(case["functions"], options)
    _warm_up(program, divided.family, divided.degree)
    row = {"family": divided.family, "degree": divided.degree, "elements": divided.elements}
    found = {"runs": [row | assembled(PROGRAMS[program](divided))]}
    if case["repeat"]:
        return found
    coarse = Discretisation(divided.family, divided.degree, options.checked_boxes)
    return found | checks(PROGRAMS[program](coarse), options.modes)


def assembled(assembler: Ours | PlainDolfinx) -> dict[str, Any]:
    """What one assembly of stiffness and mass takes.

    Returns
    -------
    dict
        Processor seconds of ``stiffness`` and of ``mass``; ``memory``, the peak above that before
        (MB), ``finished``, what the matrices hold (MB); ``dofs``.
    """
    with measured() as both:
        begun = process_time()
        K = assembler.stiffness()
        stiffness = process_time() - begun
        M = assembler.mass()
    return {
        "dofs": K.getSize()[0],
        "stiffness": stiffness,
        "mass": both.processor - stiffness,
        "memory": both.memory,
        "finished": _BYTES * sum(matrix.getInfo()["nz_used"] for matrix in (K, M)) / 1e6,
    }


def checks(assembler: Ours | PlainDolfinx, modes: int) -> dict[str, list[dict[str, Any]]]:
    """What the matrices do to rigid motions, and their lowest eigenvalues."""
    found = checked(*matrices_of(assembler), assembler.motions(), modes)
    values = {name: found.pop(name) for name in ("inertia", "eigenvalues")}
    return {
        "checks": [found],
        "values": [
            {"what": what, "number": i, "value": value}
            for what, each in values.items()
            for i, value in enumerate(each)
        ],
    }


def times(result: StudyResult) -> pd.DataFrame:
    """Medians of each program and discretisation; ratios are to the yardstick of the same round."""
    frame = result.frame()
    if frame.empty:
        return frame
    both = frame["stiffness"] + frame["mass"]
    element = both / frame["elements"]
    yardstick = element[(frame["functions"] == YARDSTICK[0]) & (frame["program"] == YARDSTICK[1])]
    unit = frame["repeat"].map(dict(zip(frame["repeat"][yardstick.index], yardstick, strict=True)))
    frame["per_element"], frame["per_dof"] = 1e3 * element, 1e6 * both / frame["dofs"]
    frame["ratio"], frame["memory_ratio"] = element / unit, frame["memory"] / frame["finished"]
    for name in ("stiffness", "mass"):
        frame[name] = 1e3 * frame[name] / frame["elements"]
    return medians(frame)


def checks_table(result: StudyResult) -> pd.DataFrame:
    """What the matrices give; inertia and eigenvalues relative to those of the first program."""
    frame, values = result.frame("checks"), result.frame("values")
    if frame.empty:
        return frame
    at = ["functions", "what", "number"]
    values["first"] = values.groupby(at)["value"].transform("first")
    volume = values.query("what == 'inertia' and number == 0").set_index(["functions", "program"])
    frame["volume"] = [
        volume.loc[key, "value"] / (MATERIAL.rho or np.nan)
        for key in zip(frame["functions"], frame["program"], strict=True)
    ]
    values["apart"] = (values["value"] / values["first"] - 1).abs()
    worst = values.groupby(["functions", "program", "what"])["apart"].max().unstack().reset_index()
    return frame.drop(columns="repeat").merge(worst, on=["functions", "program"])


COLUMNS = {
    "functions": Column("functions"),
    **{name: Column(name, "ms/element", shown(3)) for name in ("stiffness", "mass")},
    "per_element": Column("both", "ms/element", shown(3)),
    "per_dof": Column("both", "µs/dof", shown(3)),
    "ratio": Column("of dolfinx Q2", show=shown(3)),
    "memory_ratio": Column("peak memory / finished matrices", show=shown(3)),
    "finished": Column("finished", "MB", shown(3)),
    "rigid": Column("rigid motion", show=shown(2)),
    "asymmetry": Column("asymmetry", show=shown(2)),
    "volume": Column("volume", "m³", shown(9)),
    "inertia": Column("inertia apart", show=shown(2)),
    "eigenvalues": Column("eigenvalues apart", show=shown(2)),
}
STUDY = Study(
    name="bench assembly",
    title="Assembly of stiffness and mass beside other programs",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    quick={
        "boxes": (2, 2, 1),
        "boxes_of_degree_4": (1, 1, 1),
        "checked_boxes": (2, 2, 1),
        "modes": 2,
        "repeats": 1,
    },
    process=Process("comparisons.bench.assembly:STUDY", 120.0),
    sections=[
        Section(
            "Assembly",
            "A quarter of a thick ring, divided alike everywhere.",
            tables=[
                Table(
                    "times",
                    "Processor time of stiffness and mass on one thread, medians; an element over "
                    "one of plain dolfinx Q2, assembled in the same round. Memory: peak while "
                    "assembling above that before; finished: the matrices, 12 bytes an entry.",
                    *(times, COLUMNS),
                    printed=True,
                ),
                Table(
                    "checks",
                    "What the matrices give on a coarse division: the largest force of a rigid "
                    "motion and the asymmetry of K, relative to its largest entry; volume; inertia "
                    "of rigid motions and the lowest elastic eigenvalues, relative to those of the "
                    "first program.",
                    *(checks_table, COLUMNS),
                ),
            ],
            plots=[
                Plot(
                    "times",
                    "Time of an element against degree.",
                    *(times, "degree", "ratio", ("program",), "family", "y"),
                    own=COLUMNS,
                ),
                Plot(
                    "memory",
                    "Peak memory over that of the matrices.",
                    *(times, "degree", "memory_ratio", ("program",), "family", "y"),
                    own=COLUMNS,
                ),
            ],
        )
    ],
)
