"""Mortar contact whose stiffness varies by many orders of magnitude, beside extended precision."""

import numpy as np
import pytest
from motions import dense

from scenes import run_modes
from scenes.spec.reading import load_scene

flint = pytest.importorskip("flint")

ELEMENTS = {"upper": [3, 1], "lower": [4, 1]}
BITS = 200


def scene(backend, contrast, form):
    fields = {"contacts.interface.p": f"where(x<1, 1.0, {contrast!r})"}
    fields |= {"contacts.interface.form": form, "analysis.max_frequency": 0.7}
    for body, elements in ELEMENTS.items():
        fields[f"bodies.{body}.mesh.fe"] = {
            "cell": "quadrilateral",
            "degree": 2,
            "elements": elements,
        }
        fields[f"bodies.{body}.mesh.iga"] = {"degree": [2, 2], "elements": elements}
    return load_scene("blocks", [], backend).change(fields)


def precise(result):
    """Kappa of (K + K_n - K_f) x = kappa M x from points and traces, in 200 bits."""
    system = result.system
    contact = system.contacts[0]
    interface = contact.interface
    points, p = interface.points, contact.slope
    psi = interface.trace_a.toarray()
    psi = psi[:, np.abs(psi).max(axis=0) > 0]
    k = contact.friction.along(points.x, points.normal)
    jumps = []
    for direction in (points.normal, contact.friction.mu[:, None] * k):
        parts = []
        for sign, trace, body in (
            (1, interface.trace_a, "upper"),
            (-1, interface.trace_b, "lower"),
        ):
            full = np.einsum("qi,qc->qic", sign * trace.toarray(), direction)
            parts.append(full.reshape(len(p), -1) @ dense(system.bodies[body].expansion))
        jumps.append(np.hstack(parts))
    with flint.ctx.workprec(BITS):
        psi, gap, slip, K, mass = (
            flint.arb_mat(m.tolist())
            for m in (psi, *jumps, dense(system.stiffness), dense(system.mass))
        )
        weight = [flint.arb(w) for w in points.weight.tolist()]
        share = [w / flint.arb(q) for w, q in zip(weight, p.tolist(), strict=True)]
        M = psi.transpose() * diagonal(share) * psi
        B, B_k = (psi.transpose() * diagonal(weight) * jump for jump in (gap, slip))
        flexible = (K + (B - B_k).transpose() * M.solve(B)).solve(mass)
        entries = [[float(entry.mid()) for entry in row] for row in flexible.table()]
    return 1 / np.linalg.eigvals(np.array(entries))


def diagonal(values):
    matrix = flint.arb_mat(len(values), len(values))
    for i, value in enumerate(values):
        matrix[i, i] = value
    return matrix


@pytest.mark.parametrize("contrast", [1e12, 1e15])
@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_eigenvalues_are_those_of_extended_precision(backend, form, contrast):
    result = run_modes(scene(backend, contrast, form))
    found = -(result.eigenvalues**2)
    expected = precise(result)
    assert len(found) >= 6
    distance = np.abs(found[:, None] - expected).min(axis=1)
    assert (distance / np.abs(found)).max() < 1e-9
