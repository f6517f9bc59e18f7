# ruff: noqa: D102 - the protocols say what each member is
"""A third backend: polynomials of a degree on the unit square, in less than 100 lines.

What `docs/how_to_add_a_backend.md` asks for suffices: such a body touches a Lagrange body. Its
space is that of a single quadrilateral of that degree, whose eigenvalues it must have.
"""

import numpy as np
import pytest
from bodies import PLASTIC, lagrange_body
from numpy.polynomial.legendre import legder, legval
from scipy.sparse import csr_array

from cea.body import Body
from cea.contact.contact import Contact
from cea.contact.formulations import GaussPointToSurface, Mortar, NodeToSurface, Segments
from cea.contact.interface import default_reach, pair
from cea.contact.pressure_and_friction import AlongVector, Friction, LinearLaw
from cea.eigen.driver import solve_modes
from cea.matrices import distributed
from cea.petsc import MPI
from cea.supports.boundary import Support
from cea.supports.constraints import Directions, constrain
from cea.surface import Surface
from cea.surface_points import SurfaceCells, SurfaceCoordinates, gauss_rule
from cea.system.coupled import couple
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Rectangle

DEGREE, SIZE = 4, 5
NODES = 0.5 + np.array([-0.5, -np.sqrt(21) / 14, 0.0, np.sqrt(21) / 14, 0.5])  # Gauss-Lobatto
COEFFICIENTS = np.linalg.inv(np.polynomial.legendre.legvander(2 * NODES - 1, DEGREE))


def tabulated(t):
    """Values and derivatives of the Lagrange polynomials of the nodes, each (n, SIZE)."""
    of_derivatives = 2 * legder(COEFFICIENTS)
    return legval(2 * t - 1, COEFFICIENTS).T, legval(2 * t - 1, of_derivatives).T


class Edge(Surface):
    """The lower (0) or upper (1) edge of the unit square, one element."""

    abscissa_kinds, abscissa_weights = ("nodes",), ("equal",)
    domains = np.zeros((1, 1)), np.ones((1, 1))
    cells = SurfaceCells(np.zeros(1, int), np.array([[[0.0], [1.0]]]), DEGREE, True)
    sizes = element_areas = np.ones(1)

    def __init__(self, name, end):
        super().__init__(name, SIZE**2)
        self._end = end

    @property
    def function_dofs(self):
        return np.arange(SIZE) * SIZE + self._end * DEGREE

    def tangents(self, element, xi):
        x = np.column_stack([xi, np.full_like(xi, self._end)])
        return x, np.tile([[1.0], [0.0]], (len(xi), 1, 1))

    def area_normals(self, at):
        x = self.tangents(at.element, at.xi)[0]
        return x, np.tile([0.0, 2.0 * self._end - 1], (len(x), 1)), np.ones(len(x))

    def function_points(self, kind):
        return SurfaceCoordinates(np.zeros(SIZE, int), NODES[:, None])

    def values(self, at, columns, count):
        rows = np.zeros((len(at), count))
        rows[:, columns] = tabulated(at.xi[:, 0])[0]
        return csr_array(rows)

    def gradient(self, at):
        along, across = tabulated(at.xi[:, 0]), tabulated(np.full(len(at), float(self._end)))
        slopes = (along[1], across[0]), (along[0], across[1])
        return tuple(
            csr_array(np.einsum("ni,nj->nij", *each).reshape(len(at), -1)) for each in slopes
        )

    def join_smoothly(self, at, pairs):
        return np.zeros(len(pairs), dtype=bool)

    def shares(self):
        return np.full(SIZE, 1 / SIZE)


class PolynomialSpace:
    """Polynomials on the unit square by their values at SIZE x SIZE nodes."""

    dim, comm, dof_positions = 2, MPI.COMM_SELF, None
    ranges = np.array([0, SIZE**2])

    def __init__(self):
        self.surfaces = {name: Edge(name, end) for end, name in enumerate(("y_min", "y_max"))}
        t, weights = gauss_rule(SIZE, 1, simplex=False)
        tables = tabulated(t[:, 0])
        self._line = [[(a.T * weights) @ b for b in tables] for a in tables]

    def constrain(self, supports, field):
        held = [
            Directions.of(self.surfaces[support.surface].function_dofs, axis, 0.0, number)
            for number, support in enumerate(supports)
            for axis in np.eye(2)
        ]
        return constrain(SIZE**2, Directions.joined(held, 2), field=field)

    def _products(self, p=None, q=None):
        """Integrals of products of two functions, or of their derivatives along p and q."""
        x, y = (self._line[p == axis][q == axis] for axis in (0, 1))
        return np.kron(x, y)

    def _matrix(self, blocks):
        """Matrix of the blocks of components, (2, 2, SIZE**2, SIZE**2), symmetrised."""
        whole = np.einsum("ijab->aibj", blocks).reshape(2 * SIZE**2, -1)
        rows = csr_array(0.5 * (whole + whole.T))
        return distributed(rows, rows.shape, self.comm)

    def stiffness(self, elasticity):
        blocks = np.zeros((2, 2, SIZE**2, SIZE**2))
        for j, q in np.ndindex(2, 2):
            gradient = np.zeros((2, 2, 1))
            gradient[j, q] = 1.0
            stress = elasticity.stress(gradient, np.zeros((2, 1)))[..., 0]
            for i, p in np.ndindex(2, 2):
                blocks[i, j] += stress[i, p] * self._products(p, q)
        return self._matrix(blocks)

    def mass(self, rho):
        return self._matrix(np.einsum("ij,ab->ijab", np.eye(2), rho * self._products()))


def eigenvalues(lower, rule, *, reverse):
    """Eigenvalues of a Lagrange block that slides on a lower one, points on either side."""
    upper = Rectangle((1.0, 0.7), (0.0, 1.0))
    mesh = shape_mesh(
        upper, "quadrilateral", 2, breaks=[np.linspace(0, 1, 4), np.array([1.0, 1.7])]
    )
    block = lagrange_body("upper", mesh, degree=2, material=PLASTIC, comm=MPI.COMM_SELF)
    bodies = {"upper": block, "lower": lower}
    sides = {"upper": block.surfaces["y_min"], "lower": lower.surfaces["y_max"]}
    a, b = ("lower", "upper") if reverse else ("upper", "lower")
    faces = sides[a], sides[b]
    interface = pair(*faces, rule.points_on(*faces, default_reach(*faces)))
    law = LinearLaw(np.full(len(interface.points), 30.0))
    push = Friction(0.6, AlongVector((-1.0 if reverse else 1.0, 0.0)))
    contact = Contact("pair", "pair", a, b, interface, law, push, coupling=rule.coupling)
    return solve_modes(couple(bodies, [contact]).pencil(), 2.0).eigenvalues


@pytest.mark.parametrize("reverse", [False, True], ids=["points on Lagrange", "points on it"])
@pytest.mark.parametrize(
    "rule", [GaussPointToSurface(5), NodeToSurface(), Segments(), Mortar()], ids=str
)
def test_a_body_of_a_third_backend_slides_as_a_lagrange_body_of_its_space(rule, reverse):
    supports = (Support("y_min"),)
    own = Body("lower", PolynomialSpace(), PLASTIC, supports)
    breaks = [np.array([0.0, 1.0])] * 2
    mesh = shape_mesh(Rectangle((1.0, 1.0)), "quadrilateral", 1, breaks=breaks)
    options = {"degree": DEGREE, "material": PLASTIC, "supports": supports}
    same = lagrange_body("lower", mesh, comm=MPI.COMM_SELF, **options)
    found, expected = (eigenvalues(each, rule, reverse=reverse) for each in (own, same))
    assert len(found) > 20
    assert found.real.max() > 1e-3  # it flutters
    assert found**2 == pytest.approx(expected**2, rel=1e-9, abs=1e-9)  # it may slide freely
