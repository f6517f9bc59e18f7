"""Rows at many points compressed to as many as are independent: by hand, and on interfaces."""

import numpy as np
import pytest
from blocks import assemble, two_blocks
from covering import covering
from motions import dense
from scipy.linalg import qr
from scipy.sparse import csr_array, diags_array, hstack, kron

from cea.contact.compression import compressed
from cea.petsc import MPI


def hats(x, cells):
    """Hat functions on equal cells at points of [0, 1]."""
    return np.maximum(0.0, 1 - np.abs(cells * x[:, None] - np.arange(cells + 1)))


def rows(points=700, seed=1):
    """Gaps between two functions on meshes that do not match, slips of other functions."""
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(size=points))
    left, right = hats(x, 40), -hats(x, 33)
    gap = np.hstack([left, right, np.zeros((points, 50))])
    slip = np.hstack([0.3 * left, np.zeros_like(right), hats(x, 49)])
    return csr_array(gap), csr_array(slip), x[:, None]


def face(left, right, friction):
    """Gaps and slips at 3 x 3 points in each of left x left cells, against right x right cells."""
    nodes, _ = np.polynomial.legendre.leggauss(3)
    along = ((np.arange(left)[:, None] + (nodes + 1) / 2) / left).ravel()
    near, far = (csr_array(hats(along, cells)) for cells in (left, right))
    gap = csr_array(hstack([kron(near, near), -kron(far, far)]))
    x = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
    mu = np.broadcast_to(friction(x[:, 0]), len(x))
    return gap, csr_array(diags_array(mu) @ gap), x


def size(matrix):
    return np.abs(matrix).max()


def test_products_are_kept_and_rows_are_as_many_as_the_rank():
    gap, slip, x = rows()
    closure, reaction = (m.toarray() for m in compressed(gap, slip, x, MPI.COMM_SELF))
    gap, slip = gap.toarray(), slip.toarray()
    assert len(closure) == np.linalg.matrix_rank(gap) == np.linalg.matrix_rank(closure)
    assert size(closure.T @ closure - gap.T @ gap) < 1e-13 * size(gap.T @ gap)
    assert size(reaction.T @ closure - slip.T @ gap) < 1e-13 * size(slip.T @ gap)


@pytest.mark.parametrize("friction", [lambda x: 0.3, lambda x: 0.2 + x**2])
def test_an_interface_gives_what_one_dense_factorisation_gives(friction):
    gap, slip, x = face(10, 9, friction)
    closure, reaction = compressed(gap, slip, x, MPI.COMM_SELF)
    gap, slip, J, R = (m.toarray() for m in (gap, slip, closure, reaction))
    assert len(J) == np.linalg.matrix_rank(gap)
    assert size(J.T @ J - gap.T @ gap) < 1e-13 * size(gap.T @ gap)
    q, triangle, order = qr(gap, mode="economic", pivoting=True)
    q, triangle = q[:, : len(J)], triangle[: len(J), np.argsort(order)]
    # R is the one matrix that gives the friction with this J.
    friction_of_gaps = np.linalg.lstsq(J.T, triangle.T @ (q.T @ slip), rcond=None)[0]
    assert size(R - friction_of_gaps) < 1e-12 * size(slip)


def test_small_rows_keep_their_digits_beside_large_ones():
    """Stiffness that varies by 1e15: that of the soft half, which only soft points touch."""
    gap, slip, x = rows()
    scale = np.sqrt(np.where(x[:, 0] < 0.52, 1.0, 1e15))[:, None]
    closure, reaction = compressed(
        csr_array(gap * scale), csr_array(slip * scale), x, MPI.COMM_SELF
    )
    soft = np.r_[0:19, 41:57]
    normal, friction = (
        (matrix[:, soft].T @ closure[:, soft]).toarray() for matrix in (closure, reaction)
    )
    gap, slip = (m.toarray()[:, soft] for m in (gap, slip))
    assert size(normal - gap.T @ gap) < 1e-12 * size(normal)
    assert size(friction - slip.T @ gap) < 1e-12 * size(friction)


def test_normals_along_axes_leave_rounding_that_is_no_gap():
    gap, slip, x = rows()
    noisy = gap.toarray()
    noisy[:, 80:90] = 1e-14 * np.random.default_rng(2).normal(size=(len(noisy), 10))
    closure, _ = compressed(csr_array(noisy), slip, x, MPI.COMM_SELF)
    assert closure.shape[0] == np.linalg.matrix_rank(gap.toarray())


@pytest.mark.parametrize(
    ("backend", "method"), covering(["fe", "iga"], ["mortar", "segments"], strength=1)
)
def test_operators_of_an_interface_do_not_fill_as_it_grows(backend, method):
    """Entries for each force: their number settles where a full matrix doubles it."""
    entries = []
    for n in (12, 24):
        data = two_blocks(backend, {"method": method}, held=True, P=1e9)
        data["contacts"]["interface"]["form"] = "saddle"
        for body, elements in (("upper", [n, 2, 1]), ("lower", [2 * n + 1, 5, 1])):
            data["bodies"][body]["mesh"][backend]["elements"] = elements
        forces = assemble(data).pencil().forces[0]
        compliance = np.count_nonzero(dense(forces.compliance))
        closure = np.count_nonzero(np.abs(dense(forces.closure)) > 1e-16)
        entries.append((closure + compliance) / forces.closure.getSize()[0])
    assert entries[1] < 1.4 * entries[0]
