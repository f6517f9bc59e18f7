"""Processor time per element of the stiffness and mass of a box, by this program and by dolfinx.

All cases are repeated in rounds. Each round contains plain dolfinx on quadratic hexahedra, to which
the other times are relative: other load on the machine then cancels.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from time import process_time
from typing import Annotated, Any, Literal

import pandas as pd

from cea.body import Body
from cea.errors import require
from cea.material import IsotropicMaterial
from cea.petsc import MPI  # ahead of dolfinx
from comparisons.study.columns import medians
from comparisons.study.numbers import shown
from comparisons.study.sections import Column, Plot, Section, Table
from comparisons.study.study import Case, Process, Session, Study, StudyResult, at_least_one
from meshes.shapes import Box
from scenes.building.build import build_body
from scenes.spec.body import BodySpec, FeMesh, IgaMesh, MeshSpec

import ufl  # isort: skip
from dolfinx.fem import form, functionspace  # isort: skip
from dolfinx.fem.petsc import assemble_matrix  # isort: skip
from dolfinx.mesh import CellType, create_box  # isort: skip

Family = Literal["NURBS", "Q", "P"]
"""NURBS of highest continuity, Lagrange hexahedra, Lagrange tetrahedra."""
Boxes = tuple[int, int, int]  # elements along each side; tetrahedra are such boxes divided into six
DEGREES: Mapping[Family, tuple[int, ...]] = {"NURBS": (2, 3, 4), "Q": (1, 2, 3), "P": (1, 2, 3)}
"""Degrees of each family."""
YARDSTICK = ("Q2", "dolfinx")  # reference that all times are relative to
MATERIAL = IsotropicMaterial(E=1.0, nu=0.3, rho=1.0)
_CELLS: Mapping[str, Literal["hexahedron", "tetrahedron"]] = {"Q": "hexahedron", "P": "tetrahedron"}
_WEDGES = 6  # tetrahedra per box
_OPTIONS = {"cffi_extra_compile_args": ["-O3", "-march=native"]}


def this_program(family: Family, degree: int, boxes: Boxes) -> Body:
    """Return a body without supports; its space is built, its matrices are not assembled."""
    box = Box((1.0, 1.0, 1.0))
    if family == "NURBS":
        mesh = MeshSpec(iga=IgaMesh((degree,) * 3, boxes))
        return build_body("box", BodySpec("iga", box, MATERIAL, mesh))
    mesh = MeshSpec(fe=FeMesh(_CELLS[family], degree, elements=boxes))
    return build_body("box", BodySpec("fe", box, MATERIAL, mesh))


class PlainDolfinx:
    """dolfinx used as in its demos, compiled for this machine: vector-valued forms."""

    def __init__(self, family: Family, degree: int, boxes: Boxes) -> None:
        corners = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]
        mesh = create_box(MPI.COMM_SELF, corners, boxes, CellType[_CELLS[family]])
        self._space = functionspace(mesh, ("Lagrange", degree, (3,)))
        self._degrees = 2 * (degree - (family == "P")), 2 * degree

    def stiffness(self) -> Any:
        """Assemble a new PETSc AIJ matrix, with quadrature exact on affine cells."""
        u, v = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        lam, mu = MATERIAL.lame
        strain = ufl.sym(ufl.grad(u))
        stress = lam * ufl.tr(strain) * ufl.Identity(3) + 2 * mu * strain
        return _assembled(ufl.inner(stress, ufl.sym(ufl.grad(v))), self._degrees[0])

    def mass(self) -> Any:
        """Assemble a new PETSc AIJ matrix."""
        u, v = ufl.TrialFunction(self._space), ufl.TestFunction(self._space)
        return _assembled(MATERIAL.rho * ufl.inner(u, v), self._degrees[1])


def _assembled(integrand: Any, degree: int) -> Any:
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    matrix = assemble_matrix(form(integrand * dx, jit_options=dict(_OPTIONS)))
    matrix.assemble()
    return matrix


PROGRAMS: Mapping[str, Callable[[Family, int, Boxes], Body | PlainDolfinx]] = {
    "this program": this_program,
    "dolfinx": PlainDolfinx,
}


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    boxes: Annotated[Boxes, "Elements along each side."] = (16, 16, 8)
    repeats: Annotated[int, "Rounds; medians are reported."] = 3

    def __post_init__(self) -> None:
        at_least_one(repeats=self.repeats)
        require(min(self.boxes) >= 1, "boxes", self.boxes, "one or more along each direction")


def cases(options: Options) -> Iterator[Case]:
    """Every discretisation by every program that has it, in rounds."""
    for repeat in range(options.repeats):
        for family, degrees in DEGREES.items():
            programs = ["this program"] if family == "NURBS" else [*PROGRAMS]
            for degree, program in product(degrees, programs):
                yield {"family": family, "degree": degree, "program": program, "repeat": repeat}


@cache
def _warm_up(program: str, family: Family, degree: int) -> None:
    """Assemble the smallest body once in a process, which compiles forms."""
    assembled(PROGRAMS[program](family, degree, (1, 1, 1)))


def evaluate(case: Case, session: Session) -> dict[str, Any]:
    """Return elements, dofs and processor times of an assembly."""
    boxes, of = session.options.boxes, (case["family"], case["degree"])
    _warm_up(case["program"], *of)
    elements = boxes[0] * boxes[1] * boxes[2] * (_WEDGES if case["family"] == "P" else 1)
    return {"elements": elements} | assembled(PROGRAMS[case["program"]](*of, boxes))


def assembled(program: Body | PlainDolfinx) -> dict[str, Any]:
    """Return the dofs and the processor time (s) of each matrix."""
    begun = process_time()
    dofs = program.stiffness().getSize()[0]
    stiffness = process_time()
    program.mass()
    return {"dofs": dofs, "stiffness": stiffness - begun, "mass": process_time() - stiffness}


def times(result: StudyResult) -> pd.DataFrame:
    """Medians of each program and discretisation, relative to the reference of the round."""
    frame = result.frame()
    both = frame["stiffness"] + frame["mass"]
    element, name = both / frame["elements"], frame["family"] + frame["degree"].astype(str)
    yardstick = element[(name == YARDSTICK[0]) & (frame["program"] == YARDSTICK[1])]
    unit = frame["repeat"].map(dict(zip(frame["repeat"][yardstick.index], yardstick, strict=True)))
    frame["per_element"], frame["per_dof"] = 1e3 * element, 1e6 * both / frame["dofs"]
    frame["ratio"] = element / unit
    for matrix in ("stiffness", "mass"):
        frame[matrix] = 1e3 * frame[matrix] / frame["elements"]
    return medians(frame)


COLUMNS = {
    **{name: Column(name, "ms/element", shown(3)) for name in ("stiffness", "mass")},
    "per_element": Column("both", "ms/element", shown(3)),
    "per_dof": Column("both", "µs/dof", shown(3)),
    "ratio": Column("of dolfinx Q2", show=shown(3)),
}
_CAPTION = "Medians of processor time on one thread, per element over dolfinx Q2 of the round."
TIMES = Table("times", _CAPTION, times, COLUMNS, printed=True)
_AXES: dict[str, Any] = {
    "x": "degree",
    "y": "ratio",
    "series": ("program",),
    "panel": ("family",),
    "log": "y",
}
PLOT = Plot("ratio", "Time per element against degree.", times, own=COLUMNS, **_AXES)
STUDY = Study(
    name="bench assembly",
    title="Assembly of stiffness and mass, compared with dolfinx",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    quick={"boxes": (2, 2, 1), "repeats": 1},
    process=Process("comparisons.bench.assembly:STUDY", 120.0),
    sections=[Section("Assembly", "A box.", None, [TIMES], [PLOT], of="runs")],
)
