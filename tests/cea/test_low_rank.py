"""Damping of low rank: systems, signs of determinants."""

import numpy as np
import pytest
from blocks import assemble, two_blocks
from covering import covering
from eigen_numbers import damped
from petsc_matrices import dense_pencil, to_petsc

from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.pencil import Pencil, Term
from cea.eigen.shifted import Shifted
from cea.eigen.unformed import LowRank, UnformedTerm

GPTS = {"method": "gpts", "points": 3}
RNG = np.random.default_rng(4)


def with_piece(pencil, piece):
    """A pencil with one piece of low rank more, by the parameter d."""
    term = UnformedTerm(piece, Coefficient({"d": (1.0, 1.0)}))
    parameters = [*pencil.parameters.values(), Parameter("d", 1.0)]
    return Pencil(pencil.terms, parameters, pencil.forces, [term])


@pytest.mark.parametrize(
    ("backend", "form", "shift"),
    covering(["iga", "fe"], ["penalty", "saddle"], [0.7, 2.1]),
)
def test_systems_are_those_of_the_full_matrix(backend, form, shift):
    turning = {"penalty": 0.3, "saddle": 0.0}[form]
    data = two_blocks(backend, GPTS, mu=0.4 if turning else 0.0, held=True, form=form)
    plain = damped(assemble(data).pencil(), 0.1, 0.02, turning=turning)
    rows = plain.at().size
    piece = LowRank(RNG.standard_normal((rows, 5)), 10.0 ** -np.arange(5.0))
    matrices = with_piece(plain, piece).at()
    M, D, K = dense_pencil(matrices)
    P = shift**2 * M + shift * D + K
    b = RNG.standard_normal((rows, 3)) + 1j * RNG.standard_normal((rows, 3))
    factors = Shifted.quadratic(matrices, shift)
    for transposed, A in ((False, P), (True, P.T)):
        x, _ = factors.solve_with_forces(b, transposed=transposed)
        assert x == pytest.approx(np.linalg.solve(A, b), abs=1e-9)
    factors.free()


def test_signs_of_determinants_know_the_piece():
    """Negative stiffness: some shifts have an odd number of real eigenvalues beyond them."""
    stiffness = np.diag([-2.0, -1.0, 3.0, 4.0])
    terms = [
        Term("mass", to_petsc(np.eye(4))),
        Term("stiffness", to_petsc(stiffness)),
        Term("stiffness", to_petsc(0.1 * RNG.standard_normal((4, 4))), symmetric=False),
    ]
    piece = LowRank(RNG.standard_normal((4, 3)), np.array([1.0, 5.0, 0.3]))
    matrices = with_piece(Pencil(terms), piece).at()
    M, C, K = dense_pencil(matrices)
    found = []
    for shift in np.linspace(0.05, 2.0, 12):
        factors = Shifted.quadratic(matrices, float(shift))
        sign = np.sign(np.linalg.det(shift**2 * M + shift * C + K))
        assert factors.parity() == int(sign < 0)
        found.append(factors.parity())
        factors.free()
    assert set(found) == {0, 1}
