"""Factors of single precision, by nodes, in panels, on disk: they say what those of double do."""

import numpy as np
import pytest
import scipy.sparse as sp
from petsc_matrices import to_numpy, to_petsc

from cea.eigen import field_of_values, mumps
from cea.eigen.factors_on_disk import factors_on_disk, folder_of_factors
from cea.eigen.mumps import Mumps, unknowns_of_nodes
from cea.eigen.shifted import Shifted
from cea.eigen.single_precision import relative_rounding, shares_inertia
from cea.matrices import destroy
from scenes import load_scene, run_modes
from scenes.run import coupled

LARGE = 10**9


def laplacian(n: int) -> sp.csr_array:
    line = sp.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n))
    return sp.csr_array(sp.kron(line, sp.eye_array(n)) + sp.kron(sp.eye_array(n), line))


def single_factors(matrix: sp.csr_array) -> Mumps:
    return Mumps(to_petsc(matrix), symmetric=True, inertia=True, single=True)


def test_rounding_is_that_of_single_precision():
    """The estimate lies below the norm of F^-1 H - 1, which the whole inverse shows, not far."""
    matrix = laplacian(12)
    factors = single_factors(matrix)
    assert factors.single
    inverse = factors.solve_block(np.asfortranarray(matrix.toarray()))
    exact = np.linalg.norm(inverse - np.eye(len(inverse)), 2)
    found = relative_rounding(factors)
    assert 1e-9 < found < 10 * exact
    assert found > 1e-2 * exact
    assert shares_inertia(factors)
    factors.free()


def test_what_rounding_may_hide_is_not_trusted():
    """A stiffness of 1e12 beside one of 1: the soft motion is lost in single precision."""
    soft = laplacian(12) * 1e-9
    stiff = sp.csr_array(np.ones((144, 144)) * 1e3)
    factors = single_factors(sp.csr_array(soft + stiff))
    trusted = not factors.negative_eigenvalues() and shares_inertia(factors)
    assert not trusted
    factors.in_double()
    assert not factors.single
    factors.free()


@pytest.mark.parametrize("mu", [0.2, 3.0])
def test_field_of_values_in_both_precisions(backend, mu, monkeypatch):
    """What bounds growth, and what does not, is the same."""
    scene = load_scene("blocks", backend=backend).change({"contacts.interface.mu": mu})
    system, _, _ = coupled(scene)
    matrices = system.pencil().at()
    depth = 0.1 * (2 * np.pi * scene.analysis.max_frequency) ** 2
    fields = []
    for large in (LARGE, 0):
        for module in (field_of_values, mumps):
            monkeypatch.setattr(module, "_LARGE", large)
        fields.append(field_of_values.field_of_values(matrices, depth, cone=True))
    double, single = fields
    assert single.bounded == double.bounded
    if double.bounded:
        assert single.slope == pytest.approx(double.slope, rel=1e-3)


def test_modes_are_those_of_small_systems(backend, monkeypatch):
    """Orders by node, panels and evidence in single precision change nothing but rounding."""
    scene = load_scene("blocks", backend=backend)
    plain = run_modes(scene).modes
    for module in (field_of_values, mumps):
        monkeypatch.setattr(module, "_LARGE", 0)
    modes = run_modes(scene).modes
    assert len(modes) == len(plain)
    np.testing.assert_allclose(modes.eigenvalues, plain.eigenvalues, rtol=1e-9, atol=1e-9)
    assert modes.window.complete == plain.window.complete


def test_nodes_are_seen_where_there_are_any():
    nodes = to_petsc(sp.csr_array(sp.kron(laplacian(4), np.ones((3, 3)))))
    ragged = to_petsc(laplacian(6))
    assert unknowns_of_nodes(nodes) == 3
    assert unknowns_of_nodes(ragged) == 1
    destroy(nodes, ragged)


@pytest.mark.parametrize("beside", [0, 2, 4])
def test_nodes_of_three_are_not_taken_for_nodes_of_two(beside):
    """Rows of neighbours have as many entries; those of one node have the same columns."""
    nodes = sp.kron(laplacian(12), np.ones((3, 3)))
    whole = to_petsc(sp.csr_array(sp.block_diag([nodes, sp.eye_array(beside)])))
    assert unknowns_of_nodes(whole) == (1 if beside else 3)
    destroy(whole)


def test_forces_beside_displacements_leave_nodes_to_be_seen(backend):
    scene = load_scene("disc_pad", backend=backend).change(
        {
            "contacts.pad_disc.formulation": {"method": "mortar"},
            "bodies.pad.mesh.iga.elements": [3, 5, 1],
            "bodies.disc.mesh.iga.elements": [4, 30, 1],
            "bodies.disc.mesh.fe.elements": [3, 24, 1],
            "bodies.pad.mesh.fe.elements": [3, 5, 1],
        }
    )
    matrices = coupled(scene)[0].pencil().at()
    assert matrices.multipliers.size % 6
    factors = Shifted(matrices, 1e9)
    assert unknowns_of_nodes(factors._factors.matrix) == 3
    force = np.random.default_rng(4).standard_normal((matrices.size, 2))
    x, f = factors.solve_with_forces(force)
    assert f.shape == (matrices.multipliers.size, 2)
    A, J, L, C = (
        to_numpy(each)
        for each in (
            matrices.operator(1e9),
            matrices.multipliers.closure,
            matrices.multipliers.reaction,
            matrices.multipliers.compliance,
        )
    )
    assert A @ x + L.T @ f == pytest.approx(force, abs=1e-7)
    assert J @ x == pytest.approx(C @ f, rel=1e-6, abs=1e-9 * np.abs(J @ x).max())
    factors.free()


def test_factors_on_disk_solve_the_same():
    matrix = laplacian(40)
    b = np.asfortranarray(np.random.default_rng(3).standard_normal((matrix.shape[0], 5)))
    assert folder_of_factors() is None
    with factors_on_disk() as folder:
        factors = Mumps(to_petsc(matrix), symmetric=False)
        assert any(file.stat().st_size for file in folder.iterdir())
        x = factors.solve_block(b)
        factors.free()
    assert folder_of_factors() is None
    assert not folder.exists()
    np.testing.assert_allclose(matrix @ x, b, atol=1e-11)
