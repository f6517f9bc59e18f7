"""Contact stiffness that varies by orders of magnitude: extended precision, compressed rows."""

import numpy as np
import pytest
from motions import dense
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from cea.contact.compression import compressed
from cea.petsc import MPI
from scenes import run_modes
from scenes.spec.reading import load_scene

BITS = 200


def scene(backend, contrast, form):
    fields = {"contacts.interface.p": f"where(x<1, 1.0, {contrast!r})"}
    fields |= {"contacts.interface.form": form, "analysis.max_frequency": 0.7}
    for body, elements in (("upper", [3, 1]), ("lower", [4, 1])):
        mesh = f"bodies.{body}.mesh"
        fields[f"{mesh}.fe"] = {"cell": "quadrilateral", "degree": 2, "elements": elements}
        fields[f"{mesh}.iga"] = {"degree": [2, 2], "elements": elements}
    return load_scene("blocks", [], backend).change(fields)


def precise(result):
    """Kappa of (K + K_n - K_f) x = kappa M x from points and traces, in 200 bits."""
    flint = pytest.importorskip("flint")

    def diagonal(values):
        matrix = flint.arb_mat(len(values), len(values))
        for i, value in enumerate(values):
            matrix[i, i] = value
        return matrix

    system = result.system
    (contact,) = system.contacts
    interface = contact.interface
    points, p = interface.points, contact.slope
    traces = {"upper": interface.trace_a.toarray(), "lower": -interface.trace_b.toarray()}
    psi = traces["upper"][:, np.abs(traces["upper"]).max(axis=0) > 0]
    k = contact.friction.along(points.x, points.normal)
    jumps = []
    for direction in (points.normal, contact.friction.mu[:, None] * k):
        full = {n: np.einsum("qi,qc->qic", t, direction) for n, t in traces.items()}
        parts = [f.reshape(len(p), -1) @ dense(system.bodies[n].expansion) for n, f in full.items()]
        jumps.append(np.hstack(parts))
    K, mass = (
        block_diag(*(dense(getattr(body, kind)()) for body in system.bodies.values()))
        for kind in ("stiffness", "mass")
    )
    with flint.ctx.workprec(BITS):
        psi, gap, slip, K, mass = (flint.arb_mat(m.tolist()) for m in (psi, *jumps, K, mass))
        weight = [flint.arb(w) for w in points.weight.tolist()]
        share = [w / flint.arb(q) for w, q in zip(weight, p.tolist(), strict=True)]
        M = psi.transpose() * diagonal(share) * psi
        B, B_k = (psi.transpose() * diagonal(weight) * jump for jump in (gap, slip))
        flexible = (K + (B - B_k).transpose() * M.solve(B)).solve(mass)
        entries = [[float(entry.mid()) for entry in row] for row in flexible.table()]
    return 1 / np.linalg.eigvals(np.array(entries))


@pytest.mark.parametrize("contrast", [1e12, 1e15])
@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_eigenvalues_are_those_of_extended_precision(backend, form, contrast):
    result = run_modes(scene(backend, contrast, form))
    found = -(result.eigenvalues**2)
    assert len(found) >= 6
    distance = np.abs(found[:, None] - precise(result)).min(axis=1)
    assert (distance / np.abs(found)).max() < 1e-9


def hats(x, cells):
    """Hat functions on equal cells at points of [0, 1]."""
    return np.maximum(0.0, 1 - np.abs(cells * x[:, None] - np.arange(cells + 1)))


@pytest.mark.parametrize("case", ["even", "soft half", "noise"])
def test_compressed_rows_keep_products_and_are_as_many_as_the_rank(case):
    """Of gaps between functions on meshes that do not match, slips of other functions.

    Half of the rows may be larger by 3e7, beside which the others keep their digits; or columns
    that are zero hold rounding, as where normals are along axes.
    """
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(size=700))
    left, right = hats(x, 40), -hats(x, 33)
    gap = np.hstack([left, right, np.zeros((700, 50))])
    slip = np.hstack([0.3 * left, np.zeros_like(right), hats(x, 49)])
    rank, touched = np.linalg.matrix_rank(gap), slice(None)
    if case == "noise":
        gap[:, 80:90] = 1e-14 * rng.normal(size=(700, 10))
    if case == "soft half":
        scale = np.sqrt(np.where(x < 0.52, 1.0, 1e15))[:, None]
        gap, slip, touched = scale * gap, scale * slip, np.r_[0:19, 41:57]
    rows = compressed(csr_array(gap), csr_array(slip), x[:, None], MPI.COMM_SELF)
    closure, reaction = (matrix.toarray() for matrix in rows)
    within = 1e-12 if case == "soft half" else 1e-13
    assert case == "soft half" or len(closure) == np.linalg.matrix_rank(closure) == rank
    for found, given in ((closure, gap), (reaction, slip)):
        expected = given[:, touched].T @ gap[:, touched]
        error = np.abs(found[:, touched].T @ closure[:, touched] - expected).max()
        assert error < within * np.abs(expected).max()
