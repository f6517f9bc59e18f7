"""Hertz contact: radius and peak pressure converge to the closed form where c_n is stiff.

Each body is a half space under its own contact, small beside body and radius. With the load F per
length, the relative radius R and 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2 the pressure is
peak sqrt(1 - x^2 / a^2) within the half width a = sqrt(4 F R / (pi E*)) (K. L. Johnson, Contact
Mechanics, 1985, section 4.2). The law yields by p / c_n, which makes a contact wider and lower by a
part that falls like 1 / c_n; elements of size h know its rim to h. With c_n h kept both errors fall
like h at least.
"""

import numpy as np
import pytest

from scenes import load_scene, run_static

FINE = 0.02
"""Extent (m) of the elements of equal size around the contact, which reaches to 0.0167."""
ORDER, TOLERANCE = 1.0, 0.35
"""Of convergence: where the rim lies in its element changes from mesh to mesh."""


def graded(low, high, first, largest):
    """Ends of elements that grow by half the distance from the first one, up to a largest."""
    x = np.linspace(low, high, 2001)
    middles = 0.5 * (x[1:] + x[:-1]) - low
    passed = np.cumsum(np.diff(x) / np.minimum(largest, first + 0.5 * middles))
    even = np.linspace(0, passed[-1], round(passed[-1]) + 1)
    return np.interp(even, [0, *passed], x)


def scene(backend, elements, c_n):
    """Half of a cylinder on a block, with so many elements over :data:`FINE`, graded beyond.

    Elements of the lower block are smaller by a fifth, and match none of the upper one.
    """
    built_in = load_scene("hertz_cylinder", backend=backend)
    size, first = built_in.bodies["upper"].geometry.extent[-1][1], FINE / elements
    depth = graded(0, size, first, size / 4)
    changes = {
        "contacts.interface.c_n": c_n,
        "contacts.interface.formulation": {"method": "segments"},
    }
    for body, more, down in (("upper", 0, depth), ("lower", round(elements / 4), -depth[::-1])):
        even = np.linspace(0, FINE, elements + more + 1)[:-1]
        along = np.concatenate([even, graded(FINE, size, first, size / 4)])
        mesh = f"bodies.{body}.mesh.{backend}"
        changes[f"{mesh}.elements"] = [len(along) - 1, len(down) - 1]
        changes[f"{mesh}.through"] = {"x": along[1:-1].tolist(), "y": down[1:-1].tolist()}
    return built_in.change(changes)


def errors(result):
    """Relative errors of the half width by second moment and by area, of peak and force."""
    upper, lower = (result.scene.bodies[name] for name in ("upper", "lower"))
    compliance = sum((1 - b.material.nu**2) / b.material.E for b in (upper, lower))
    (low, high), _ = upper.geometry.extent
    load = 2 * result.scene.loads[0].pressure * (high - low)
    a = np.sqrt(4 * load * upper.geometry.radii["x"] * compliance / np.pi)
    state = result.system.steady.contacts["interface"]
    points = result.interfaces["interface"].points
    x, force = np.abs(points.x[:, 0]), points.weight * state.pressure
    peak = state.pressure[np.argmin(x)] / (2 * load / (np.pi * a))
    moment = 2 * np.sqrt(force @ x**2 / force.sum()) / a
    return np.array([moment, state.closed_area / a, peak, 2 * force.sum() / load]) - 1, a


@pytest.mark.convergence
@pytest.mark.parametrize("backend", [pytest.param("fe", marks=pytest.mark.slow), "iga"])
def test_a_cylinder_on_a_block(backend):
    row = np.array([8, 16, 32])
    found = [errors(run_static(scene(backend, n, 1e15 * n / row[0]))) for n in row]
    radius, closed, peak, load = np.abs([each for each, _ in found]).T
    rates = [-np.polyfit(np.log(row), np.log(values), 1)[0] for values in (radius, peak)]
    assert rates[0] == pytest.approx(ORDER, abs=TOLERANCE)
    assert rates[1] > ORDER - TOLERANCE
    assert (closed < FINE / row / found[0][1]).all()
    assert load.max() < 1e-9
    assert radius[-1] < 5e-4
    assert peak[-1] < 5e-4
