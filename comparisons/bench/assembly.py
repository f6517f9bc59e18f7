"""Processor time per element of the stiffness and mass of a box, by family and degree."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from time import process_time
from typing import Annotated, Any, Literal

import pandas as pd

from cea.body import Body
from cea.errors import require
from cea.material import IsotropicMaterial
from comparisons.study.columns import medians
from comparisons.study.numbers import shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Process, Session, Study, StudyResult, at_least_one
from meshes.shapes import Box
from scenes.building.build import build_body
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec

Family = Literal["NURBS", "Q", "P"]
"""NURBS of highest continuity, Lagrange hexahedra, Lagrange tetrahedra."""
Boxes = tuple[int, int, int]  # elements along each side; tetrahedra are such boxes divided into six
DEGREES: Mapping[Family, tuple[int, ...]] = {"NURBS": (2, 3, 4), "Q": (1, 2, 3), "P": (1, 2, 3)}
"""Degrees of each family."""
MATERIAL = IsotropicMaterial(E=1.0, nu=0.3, rho=1.0)
_CELLS: Mapping[str, Literal["hexahedron", "tetrahedron"]] = {"Q": "hexahedron", "P": "tetrahedron"}
_WEDGES = 6  # tetrahedra per box


def body_of(family: Family, degree: int, boxes: Boxes) -> Body:
    """Return a body without supports; its space is built, its matrices are not assembled."""
    box = Box((1.0, 1.0, 1.0))
    if family == "NURBS":
        mesh = MeshSpec(iga=IgaMesh((degree,) * 3, boxes))
        return build_body("box", BodySpec("iga", box, MATERIAL, mesh))
    mesh = MeshSpec(fe=FeMesh(_CELLS[family], degree, elements=boxes))
    return build_body("box", BodySpec("fe", box, MATERIAL, mesh))


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    boxes: Annotated[Boxes, "Elements along each side."] = (16, 16, 8)
    repeats: Annotated[int, "Rounds; medians are reported."] = 3

    def __post_init__(self) -> None:
        at_least_one(repeats=self.repeats)
        require(min(self.boxes) >= 1, "boxes", self.boxes, "one or more along each direction")


def cases(options: Options) -> Iterator[Case]:
    """Every discretisation, in rounds."""
    for repeat in range(options.repeats):
        for family, degrees in DEGREES.items():
            for degree in degrees:
                yield {"family": family, "degree": degree, "repeat": repeat}


@cache
def _warm_up(family: Family, degree: int) -> None:
    """Assemble the smallest body once in a process, which compiles forms."""
    assembled(body_of(family, degree, (1, 1, 1)))


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Return elements, dofs and processor times of an assembly."""
    boxes, of = session.options.boxes, (case["family"], case["degree"])
    _warm_up(*of)
    elements = boxes[0] * boxes[1] * boxes[2] * (_WEDGES if case["family"] == "P" else 1)
    return {"elements": elements} | assembled(body_of(*of, boxes))


def assembled(body: Body) -> dict[str, Any]:
    """Return the dofs and the processor time (s) of each matrix."""
    begun = process_time()
    dofs = body.stiffness().getSize()[0]
    stiffness = process_time()
    body.mass()
    return {"dofs": dofs, "stiffness": stiffness - begun, "mass": process_time() - stiffness}


def times(result: StudyResult) -> pd.DataFrame:
    """Medians of each discretisation."""
    frame = result.frame()
    both = frame["stiffness"] + frame["mass"]
    frame["per_element"], frame["per_dof"] = (
        1e3 * both / frame["elements"],
        1e6 * both / frame["dofs"],
    )
    for matrix in ("stiffness", "mass"):
        frame[matrix] = 1e3 * frame[matrix] / frame["elements"]
    return medians(frame)


COLUMNS = {
    **{name: Column(name, "ms/element", shown(3)) for name in ("stiffness", "mass")},
    "per_element": Column("both", "ms/element", shown(3)),
    "per_dof": Column("both", "µs/dof", shown(3)),
}
TIMES = Table(
    "times",
    "Processor time of stiffness and mass on one thread, medians.",
    times,
    COLUMNS,
    printed=True,
)
PLOT = Plot(
    "per_element",
    "Time per element against degree.",
    times,
    "degree",
    "per_element",
    ("family",),
    log="y",
    own=COLUMNS,
)
STUDY = Study(
    name="bench assembly",
    title="Assembly of stiffness and mass",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    quick={"boxes": (2, 2, 1), "repeats": 1},
    process=Process("comparisons.bench.assembly:STUDY", 120.0),
    sections=[Section("Assembly", "A box.", None, [TIMES], [PLOT], of="runs")],
)
