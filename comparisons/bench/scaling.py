"""What more unknowns, higher degrees and more ranks cost: whole runs of disc_pad."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import log
from statistics import median
from typing import Any

import pandas as pd

from cea.errors import InputError
from cea.petsc import MPI
from cea.timing import STAGES
from comparisons.study.columns import Column, medians
from comparisons.study.measure import measured
from comparisons.study.numbers import shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study
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
        if self.repeats < 1:
            raise InputError("repeats", self.repeats, "1 or more")
        if not self.ranks or min(self.ranks) < 1:
            raise InputError("ranks", self.ranks, "one or more numbers, 1 or more each")


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
    return found.query("row == @row and processor > 0") if row and len(found) else found


def runs(result: StudyResult) -> pd.DataFrame:
    """A row for each run, its stages beside each other."""
    found = stages(result)
    if found.empty:
        return found
    labels = ["row", "backend", "degree", "factor", "ranks"]
    wide = found.pivot(index=labels, columns="stage", values="processor").reset_index()
    of_run = ["unknowns", "modes", "clock", "memory"]
    whole = found.loc[found["stage"] == _WHOLE, [*labels, *of_run]]
    return whole.merge(wide, on=labels)[[*labels, *of_run, *STAGES, _WHOLE]].drop(columns="factor")


def speed_up(result: StudyResult) -> pd.DataFrame:
    """How much sooner the busiest rank is done on more ranks than on the fewest, by stage."""
    found = stages(result)
    if found.empty:
        return found
    rows = []
    for (row, stage), own in found.query("row in ('strong', 'weak')").groupby(
        ["row", "stage"], sort=False
    ):
        first, *more = own.sort_values("ranks").to_dict("records")
        rows += [
            {
                "row": row,
                "stage": stage,
                "ranks": each["ranks"],
                "fewest": first["busiest"],
                "more": each["busiest"],
                "ratio": first["busiest"] / each["busiest"],
            }
            for each in more
            if each["busiest"]
        ]
    return pd.DataFrame(rows)


def growth(result: StudyResult) -> pd.DataFrame:
    """Powers of the unknowns by which each stage grew from one size to the next, the median."""
    found, rows = stages(result, "size"), []
    for stage, own in found.groupby("stage", sort=False) if len(found) else ():
        points = own.sort_values("unknowns")[["unknowns", "processor"]].to_numpy()
        powers = [log(b[1] / a[1]) / log(b[0] / a[0]) for a, b in pairwise(points) if b[0] > a[0]]
        rows += [{"stage": stage, "power": median(powers)}] if powers else []
    return pd.DataFrame(rows)


COLUMNS = {
    **{stage: Column(stage, "s", shown(3)) for stage in (*STAGES, _WHOLE)},
    "fewest": Column("on the fewest", "s", shown(3)),
    "more": Column("on these", "s", shown(3)),
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
            tables=[
                Table(
                    "runs",
                    "Whole runs, stages in processor time of all ranks; peak memory of all ranks "
                    "above that of the program.",
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
                Table(
                    "growth",
                    "Powers of the unknowns by which processor time grew with size, medians.",
                    *(growth, COLUMNS),
                ),
            ],
            plots=[
                Plot(
                    "unknowns",
                    "Stages over unknowns.",
                    *(lambda result: stages(result, "size"), "unknowns", "processor", ("stage",)),
                    log="xy",
                    own=COLUMNS,
                ),
                Plot(
                    "degree",
                    "Runs over degree.",
                    *(
                        lambda result: stages(result, "degree"),
                        "degree",
                        "processor",
                        ("stage", "backend"),
                    ),
                    log="y",
                    own=COLUMNS,
                ),
            ],
        )
    ],
)
