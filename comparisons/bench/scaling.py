"""Time of whole runs of disc_pad on quadratic tetrahedra, by unknowns and by ranks."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import pandas as pd

from cea.errors import require
from cea.petsc import MPI
from comparisons.study.columns import medians, wide
from comparisons.study.measure import measured
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.study import Case, Process, Session, Study, StudyResult, at_least_one
from scenes import run_modes
from scenes.spec.reading import Scene, load_scene

COARSEST = {"pad": (2, 3, 1), "disc": (3, 16, 1)}
"""Boxes of the coarsest mesh along r, theta and z."""
SIZES: Mapping[str, tuple[float, ...]] = {
    "tiny": (1.0, 1.3),
    "medium": (1.6, 2.1, 2.7, 3.4),
    "large": (2.1, 2.7, 3.4, 4.4),
}
"""Factors on the boxes in each direction; runs on several ranks use the last but one."""
_WHOLE = "whole"  # label of the sum of all stages


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    size: Annotated[str, "Row of meshes: tiny, medium or large."] = "medium"
    ranks: Annotated[tuple[int, ...], "Numbers of ranks, increasing."] = (1, 2)
    repeats: Annotated[int, "Runs of each case; medians are reported."] = 1

    def __post_init__(self) -> None:
        require(self.size in SIZES, "size", self.size, f"one of {', '.join(SIZES)}")
        at_least_one(repeats=self.repeats, ranks=min(self.ranks, default=0))


def cases(options: Options) -> Iterator[Case]:
    """Runs of every size on one rank, and of the last size but one on more ranks."""
    factors = SIZES[options.size]
    for repeat in range(options.repeats):
        for factor in factors:
            yield {"row": "size", "factor": factor, "ranks": 1, "repeat": repeat}
        for ranks in options.ranks:
            yield {"row": "ranks", "factor": factors[-2], "ranks": ranks, "repeat": repeat}


def scene(case: Case, options: Any) -> Scene:
    """Return disc and pad on a refined mesh."""
    changes: dict[str, Any] = {}
    for body, boxes in COARSEST.items():
        counts = [max(1, round(case["factor"] * n)) for n in boxes]
        mesh = {"cell": "tetrahedron", "degree": 2, "elements": counts}
        changes[f"bodies.{body}.mesh.fe"] = mesh
    return load_scene("disc_pad", backend="fe").change(changes)


@cache
def _warm_up() -> None:
    """Run the coarsest mesh once in a process, which compiles forms and fills caches."""
    run_modes(scene({"factor": 1.0}, None))


def evaluate(case: Case, session: Session) -> list[dict[str, Any]]:
    """Return a row for each stage and one for the sum, with totals of the run in each."""
    assert session.scene is not None
    comm = MPI.COMM_WORLD
    _warm_up()
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


def stages(result: StudyResult) -> pd.DataFrame:
    """Medians of the stages of each run."""
    return medians(result.frame(), "stage")


def runs(result: StudyResult) -> pd.DataFrame:
    """A row for each run, with a column for each stage."""
    found = stages(result)
    labels = ["row", "factor", "ranks"]
    whole = found.loc[found["stage"] == _WHOLE, [*labels, "unknowns", "modes", "clock", "memory"]]
    every = whole.merge(wide(found, labels, "stage", "processor"), on=labels)
    return every.drop(columns="factor")


def speed_up(result: StudyResult) -> pd.DataFrame:
    """Speed-up of the busiest rank over the run with fewest ranks, by stage."""
    found = stages(result).query("row == 'ranks' and busiest > 0")
    found = found.sort_values("ranks", kind="stable")
    first = found.groupby("stage")["busiest"].transform("first")
    found = found.assign(fewest=first, ratio=first / found["busiest"])
    found = found[found["ranks"] > found["ranks"].min()]
    return found[["stage", "ranks", "fewest", "busiest", "ratio"]]


_RUNS = "Processor time of each stage and increase of peak memory, summed over ranks (s, MB)."
_RANKS = "Seconds of the busiest rank, also waiting for others, and of that of the fewest ranks."
STUDY = Study(
    name="bench scaling",
    title="More ranks and more unknowns",
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
                Table("runs", _RUNS, runs, printed=True),
                Table("ranks", _RANKS, speed_up),
            ],
            plots=[
                Plot(
                    "unknowns",
                    "Stages over unknowns.",
                    lambda result: stages(result).query("row == 'size' and processor > 0"),
                    "unknowns",
                    "processor",
                    ("stage",),
                    log="xy",
                ),
            ],
        )
    ],
)
