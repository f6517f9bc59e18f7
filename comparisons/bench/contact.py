"""Search and assembly of a contact beside evaluating the bases at its points."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import process_time
from typing import Any

import pandas as pd

from cea.contact.contact import assembled
from cea.contact.interface import default_reach, pair
from cea.errors import InputError
from cea.matrices import destroy
from cea.timing import StageTimer
from comparisons.study.columns import Column, medians
from comparisons.study.numbers import shown
from comparisons.study.result import StudyResult
from comparisons.study.sections import Plot, Section, Table
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study, at_least_one
from scenes.building.build import build_bodies, build_contacts
from scenes.spec.reading import Scene, read_scene

_FEWER = 0.9
"""Elements of the lower block along a side, relative to those of the upper: meshes do not match."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark.

    Parameters
    ----------
    elements
        Elements along each side of the upper block; 250 make a million Gauss points.
    repeats
        Measurements of each by turns; medians count.
    """

    elements: tuple[int, ...] = (40, 126, 250)
    repeats: int = 1

    def __post_init__(self) -> None:
        if not self.elements or min(self.elements) < 1:
            raise InputError("elements", self.elements, "one or more numbers, 1 or more each")
        at_least_one(repeats=self.repeats)


def cases(options: Options) -> Iterator[Case]:
    """Every mesh on both backends, by turns."""
    for repeat in range(options.repeats):
        for elements in options.elements:
            for backend in ("fe", "iga"):
                yield {"backend": backend, "elements": elements, "repeat": repeat}


def scene(case: Case, options: Options) -> Scene:
    """Quadratic blocks with 4 x 4 Gauss points on each face of the upper one."""
    return blocks(case["backend"], case["elements"], {"method": "gpts", "points": 4})


def blocks(backend: str, elements: int, formulation: dict[str, Any]) -> Scene:
    """A block on a block with friction, so many elements along each side of the upper, one high."""

    def block(low: float, along: int) -> dict[str, Any]:
        counts = [along, along, 1]
        return {
            "backend": backend,
            "geometry": {"shape": "box", "size": [1.0, 1.0, 0.5], "origin": [0.0, 0.0, low]},
            "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
            "mesh": {
                "fe": {"degree": 2, "elements": counts},
                "iga": {"degree": [2, 2, 2], "elements": counts},
            },
        }

    contact = {
        "a": "upper.z_min",
        "b": "lower.z_max",
        "formulation": formulation,
        "P": 1.0,
        "mu": 0.3,
        "friction_direction_on_a": {"vector": [1.0, 0.0, 0.0]},
    }
    lower = block(-0.5, max(1, round(_FEWER * elements)))
    return read_scene(
        {
            "name": "contact of two blocks",
            "bodies": {"upper": block(0.0, elements), "lower": lower},
            "contacts": {"contact": contact},
            "analysis": {"kind": "cea", "max_frequency": 1.0},
        }
    )


def evaluate(case: Case, session: Session) -> dict[str, float]:
    """Processor seconds of one contact, stage by stage."""
    assert session.scene is not None
    return contact_cost(session.scene)


def contact_cost(scene: Scene) -> dict[str, float]:
    """Processor seconds of the contact of two blocks.

    Returns
    -------
    dict
        Number of ``points``; seconds of ``basis``, values of the basis functions of both sides at
        the points; ``rule``, points and weights; ``search``, points located on the other side;
        ``assembly``, gap and slip operators and K_n and K_f, or what stands for them where gaps
        are projected; ``ratio`` of search and assembly to basis.
    """
    bodies = build_bodies(scene, StageTimer())
    a, b = bodies["upper"].surfaces["z_min"], bodies["lower"].surfaces["z_max"]
    for body in bodies.values():
        _ = body.expansion
    formulation = scene.contacts["contact"].formulation
    points, rule = _timed(lambda: formulation.points_on(a, b, default_reach(a, b)))
    interface, search = _timed(lambda: pair(a, b, points))
    at, opposite = interface.points.at, interface.opposite.at
    _, basis = _timed(lambda: (a.trace(at), b.trace(opposite)))
    (half,) = build_contacts(scene, {"contact": interface})
    contact, operators = _timed(lambda: assembled(bodies, half))
    if contact.projection is None:
        made, matrices = _timed(lambda: (contact.K_n, contact.K_f))
        destroy(*made)
    else:
        compliance, matrices = _timed(lambda: contact.compliance(contact.slope))
        destroy(compliance)
    assembly = operators + matrices
    seconds = {"basis": basis, "rule": rule, "search": search, "assembly": assembly}
    return {"points": len(points), **seconds, "ratio": (search + assembly) / basis}


def _timed[T](work: Callable[[], T]) -> tuple[T, float]:
    """What some work makes, and the processor time it takes (s)."""
    start = process_time()
    made = work()
    return made, process_time() - start


def costs(result: StudyResult) -> pd.DataFrame:
    """Medians for each mesh and backend."""
    return medians(result.frame())


COLUMNS = {
    **{stage: Column(stage, "s", shown(3)) for stage in ("basis", "rule", "search", "assembly")},
    "ratio": Column("search and assembly over basis", show=shown(3)),
}
STUDY = Study(
    name="bench contact",
    title="Search and assembly of a contact",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={"elements": (4, 8)},
    process=Process("comparisons.bench.contact:STUDY", 600.0),
    sections=[
        Section(
            "Contact",
            "A block on a block with friction, quadratic elements that do not match.",
            None,
            [Table("contact", "Processor time by stage.", costs, COLUMNS, printed=True)],
            [
                Plot(
                    *("contact", "Against evaluating the bases.", costs, "points", "ratio"),
                    *(("backend",), "", "x", COLUMNS),
                )
            ],
        )
    ],
)
