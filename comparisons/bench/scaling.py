"""What more unknowns, higher degrees and more ranks cost: whole runs of disc_pad."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import pandas as pd

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.study.columns import Column, medians, wide
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study, at_least_one
from scenes import run_modes
from scenes.spec.reading import Scene, load_scene

COARSEST = {"pad": (2, 3, 1), "disc": (3, 16, 1)}
"""Boxes of the coarsest mesh along r, theta and z; finer ones have each side in as many parts."""
SIZES: Mapping[str, tuple[float, ...]] = {
    "tiny": (1.0, 1.3),
    "medium": (1.6, 2.1, 2.7, 3.4),
    "large": (2.1, 2.7, 3.4, 4.4),
}
"""Factors on the boxes along each side; strong scaling takes the last but one, weak the first."""
DEGREES: Mapping[str, tuple[int, ...]] = {"fe": (1, 2, 3), "iga": (2, 3, 4)}
_WHOLE = "whole"
"""Name of all stages together."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark.

    Parameters
    ----------
    size
        Row of meshes: tiny, medium or large.
    ranks
        Numbers of ranks, rising.
    repeats
        Runs of each by turns; medians count.
    """

    size: str = "medium"
    ranks: tuple[int, ...] = (1, 2)
    repeats: int = 1

    def __post_init__(self) -> None:
        if self.size not in SIZES:
            raise InputError("size", self.size, f"one of {', '.join(SIZES)}")
        at_least_one(repeats=self.repeats, ranks=min(self.ranks, default=0))


def cases(options: Options) -> Iterator[Case]:
    """Rows of runs that differ in one thing each: size, ranks (strong, weak), or degree."""
    factors = SIZES[options.size]
    for repeat in range(options.repeats):
        for factor in factors:
            yield _case("size", factor, repeat)
        for ranks in options.ranks:
            yield _case("strong", factors[-2], repeat, ranks)
        for ranks in options.ranks:
            yield _case("weak", factors[0], repeat, ranks)
        for backend, degrees in DEGREES.items():
            for degree in degrees:
                yield _case("degree", 1.0, repeat, backend=backend, degree=degree)


def _case(
    row: str, factor: float, repeat: int, ranks: int = 1, backend: str = "fe", degree: int = 2
) -> Case:
    labels = {"row": row, "backend": backend, "degree": degree, "factor": factor}
    return labels | {"ranks": ranks, "repeat": repeat}


def scene(case: Case, options: Options) -> Scene:
    """Disc and pad; hexahedra where degrees are compared, which NURBS have too, else tetrahedra."""
    changes: dict[str, Any] = {}
    for body, boxes in COARSEST.items():
        mesh = f"bodies.{body}.mesh.{case['backend']}"
        counts = [max(1, round(case["factor"] * n)) for n in boxes]
        if case["row"] == "weak":
            counts[1] *= case["ranks"]  # unknowns of a rank stay as they are
        changes[f"{mesh}.elements"] = counts
        if case["backend"] == "iga":
            changes[f"{mesh}.degree"] = [case["degree"]] * 3
        else:
            changes[f"{mesh}.degree"] = case["degree"]
            changes[f"{mesh}.cell"] = "hexahedron" if case["row"] == "degree" else "tetrahedron"
    return load_scene("disc_pad", backend=case["backend"]).change(changes)


@cache
def _warm_up(of_degrees: bool, backend: str, degree: int) -> None:
    """Run the coarsest mesh once in a process: it loads or compiles forms and fills caches."""
    row = "degree" if of_degrees else "size"
    run_modes(scene(_case(row, 1.0, 0, backend=backend, degree=degree), Options()))


def evaluate(case: Case, session: Session) -> list[dict[str, Any]]:
    """A row for each stage of a run and one for all, with what the whole run took."""
    assert session.scene is not None
    comm = MPI.COMM_WORLD
    _warm_up(case["row"] == "degree", case["backend"], case["degree"])
    comm.Barrier()
    with measured() as cost:
        result = run_modes(session.scene)
    session.note(result)
    stages = {**result.timer.processor_seconds, _WHOLE: cost.processor}
    of_run = {
        "unknowns": result.system.size,
        "modes": len(result.eigenvalues),
        "clock": comm.allreduce(cost.clock, MPI.MAX),
        "memory": comm.allreduce(cost.memory or 0.0),
    }
    return [
        {
            "stage": stage,
            "processor": comm.allreduce(seconds),
            "busiest": comm.allreduce(seconds, MPI.MAX),
            **of_run,
        }
        for stage, seconds in stages.items()
    ]


def stages(result: StudyResult, row: str = "") -> pd.DataFrame:
    """Medians of the stages of each run, or of the runs of a row that have some."""
    found = medians(result.frame(), "stage")
    return found.query("row == @row and processor > 0") if row else found


def runs(result: StudyResult) -> pd.DataFrame:
    """A row for each run, its stages beside each other."""
    found = stages(result)
    labels = ["row", "backend", "degree", "factor", "ranks"]
    whole = found.loc[found["stage"] == _WHOLE, [*labels, "unknowns", "modes", "clock", "memory"]]
    every = whole.merge(wide(found, labels, "stage", "processor"), on=labels)
    return every.drop(columns="factor")


def speed_up(result: StudyResult) -> pd.DataFrame:
    """How much sooner the busiest rank is done on more ranks than on the fewest, by stage."""
    found = stages(result).query("row in ('strong', 'weak') and busiest > 0")
    found = found.sort_values("ranks", kind="stable")
    first = found.groupby(["row", "stage"])["busiest"].transform("first")
    found = found.assign(fewest=first, ratio=first / found["busiest"])
    found = found[found["ranks"] > found["ranks"].min()]
    return found[["row", "stage", "ranks", "fewest", "busiest", "ratio"]]


COLUMNS = {
    "fewest": Column("on the fewest", "s", shown(3)),
    "busiest": Column("on these", "s", shown(3)),
}
STUDY = Study(
    name="bench scaling",
    title="More ranks, more unknowns, higher degrees",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={"size": "tiny", "ranks": (1,)},
    process=Process("comparisons.bench.scaling:STUDY", 3600.0),
    sections=[
        Section(
            "Runs",
            of="runs",
            tables=[
                Table(
                    "runs",
                    "Whole runs, stages in processor time of all ranks (s); peak memory of all "
                    "ranks above that of the program.",
                    *(runs, COLUMNS),
                    group="row",
                    printed=True,
                ),
                Table(
                    "ranks",
                    "Processor time of the rank that works longest; what it waits for others is "
                    "work too. Strong: the same mesh on all; the ratio is the ranks at best. Weak: "
                    "as many unknowns on each rank; the ratio is 1 at best.",
                    *(speed_up, COLUMNS),
                ),
            ],
            plots=[
                Plot(
                    "unknowns",
                    "Stages over unknowns.",
                    lambda result: stages(result, "size"),
                    *("unknowns", "processor", ("stage",), "", "xy"),
                ),
                Plot(
                    "degree",
                    "Runs over degree.",
                    lambda result: stages(result, "degree"),
                    *("degree", "processor", ("stage", "backend"), "", "y"),
                ),
            ],
        )
    ],
)
