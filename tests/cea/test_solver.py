"""Krylov-Schur of SLEPc as the reference of the search by blocks: one vector at a time."""

import numpy as np
import pytest
import scipy.linalg
from petsc_matrices import to_petsc

from cea.eigen.krylov_schur import KrylovSchur, solve_modes
from cea.eigen.pencil import Pencil, Term
from cea.errors import InputError
from scenes import load_scene, run_modes, run_scene

HERTZ = 1 / (2 * np.pi)


def same(found, reference, digits=1e-9):
    """Whether as many modes were found, and each is where it was."""
    assert len(found) == len(reference)
    distances = np.abs(found.eigenvalues[:, None] - reference.eigenvalues)
    allowed = (
        digits * reference.speeds + found.growth_uncertainties + reference.growth_uncertainties
    )
    assert (distances.min(axis=0) <= allowed).all()
    assert (distances.min(axis=1) <= allowed).all()


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_both_solvers_find_the_same_modes(backend, mu):
    scene = load_scene("blocks", backend=backend).change({"contacts.interface.mu": mu})
    blocks, vectors = (run_modes(scene, solver=each) for each in ("block", "krylov-schur"))
    assert len(blocks.modes) > 3
    same(vectors.modes, blocks.modes)
    assert vectors.modes.window.complete == blocks.modes.window.complete
    assert vectors.modes.residuals.max() < 10 * blocks.modes.residuals.max() + 1e-10


def test_copies_are_found_one_after_the_other():
    """Three copies, and a pair that flutters: one vector sees one of them in a run."""
    blocks = [np.eye(3), [[2.0, 0.3], [-0.3, 2.0]], np.diag(np.linspace(3.0, 400.0, 60))]
    whole = scipy.linalg.block_diag(*blocks)
    n = len(whole)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(n, n)))[0]
    part = turn @ (0.5 * (whole + whole.T)) @ turn.T
    rest = turn @ (0.5 * (whole.T - whole)) @ turn.T
    pencil = Pencil.of(to_petsc(0.5 * (part + part.T)), to_petsc(np.eye(n)), to_petsc(rest))
    modes = solve_modes(pencil, 2.0 * HERTZ, solver="krylov-schur", left=True)
    kappa = np.sort_complex(np.linalg.eigvals(whole))
    expected = np.sqrt(-kappa + 0j)
    expected = np.where(expected.imag < 0, -expected, expected)
    expected = expected[expected.imag <= 2.0]
    assert len(modes) == len(expected)
    assert np.abs(np.sort(modes.frequencies / HERTZ) - np.sort(expected.imag)).max() < 1e-9
    assert np.abs(np.sort(modes.growth_rates) - np.sort(expected.real)).max() < 1e-9


def test_what_it_does_not_do_is_refused():
    part = to_petsc(np.diag([1.0, 2.0, 3.0]))
    terms = [Term(role, part) for role in ("mass", "stiffness", "damping")]
    with pytest.raises(InputError, match="with damping or rotation"):
        solve_modes(Pencil(terms), 1.0, solver="krylov-schur")
    with pytest.raises(InputError, match="a static analysis has no modes"):
        run_scene(load_scene("patch_test"), solver="krylov-schur")
    with pytest.raises(InputError, match="'block' or 'krylov-schur'"):
        KrylovSchur(Pencil(terms[:2]), solver="lanczos")
