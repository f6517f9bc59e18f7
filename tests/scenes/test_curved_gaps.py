"""Gaps of curved contacts are those of the shapes, however coarse the facets.

Truths are Lame's rings in closed form, distances between circles, and NURBS, whose surfaces are
those of the shapes.
"""

from pathlib import Path

import gmsh
import numpy as np
import pytest
from gmsh_models import gmsh_model

from cea.timing import StageTimer
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from scenes import run_static
from scenes.building.build import build_bodies, build_interfaces
from scenes.spec.reading import read_scene

MORTAR = {"method": "mortar"}
SEGMENTS = {"method": "segments"}
E, NU, SPRINGS, PRESSURE = 1e9, 0.3, 1e10, 1e4
INNER, MIDDLE, OUTER = 0.05, 0.07, 0.1
"""Radii (m) of the inner ring, of the contact, and of the outer ring."""


def body(backend, geometry, elements, degree=2, young=E, **more):
    """A body of quadrilaterals or quadratic splines."""
    mesh = {
        "fe": {"cell": "quadrilateral", "degree": degree, "elements": list(elements)},
        "iga": {"degree": [2, 2], "elements": list(elements)},
    }
    material = {"E": young, "nu": NU}
    return {"backend": backend, "geometry": geometry, "material": material, "mesh": mesh, **more}


def static(bodies, contact, load):
    return {
        "name": "curved",
        "bodies": bodies,
        "contacts": {"s": contact},
        "loads": [load],
        "analysis": {"kind": "static"},
    }


def rings(degree, elements, backends=("fe", "fe"), *, formulation=MORTAR, c_n=1e12):
    """A ring pressed into another by an inner pressure; springs hold both."""
    radii = {"inner": (INNER, MIDDLE), "outer": (MIDDLE, OUTER)}
    bodies = {}
    for (name, (low, high)), backend, each in zip(radii.items(), backends, elements, strict=True):
        geometry = {"shape": "ring", "inner_radius": low, "outer_radius": high}
        springs = [{"surface": name, "stiffness": [SPRINGS, SPRINGS]}]
        bodies[name] = body(backend, geometry, each, degree, springs=springs)
    contact = {"a": "inner.outer", "b": "outer.inner", "formulation": formulation, "c_n": c_n}
    around = {"circumferential_about": [0.0, 0.0, 1.0]}
    contact |= {"mu": 0.2, "friction_direction_on_a": around, "reach": 4e-3}
    return static(bodies, contact, {"surface": "inner.inner", "pressure": PRESSURE})


def lame(c_n=1e12):
    """Contact pressure (N/m^2) of the rings in closed form.

    u = A r + B / r in each; what the law takes, q / c_n, is the closure u_i - u_o.
    """
    first = E / ((1 + NU) * (1 - 2 * NU))

    def u(r):
        return np.array([r, 1 / r])

    def sigma(r):
        return first * np.array([1, -(1 - 2 * NU) / r**2])

    matrix, right = np.zeros((5, 5)), np.zeros(5)
    matrix[0, :2], right[0] = sigma(INNER) - SPRINGS * u(INNER), -PRESSURE
    matrix[1, :2] = sigma(MIDDLE)
    matrix[2, 2:4] = sigma(MIDDLE)
    matrix[1:3, 4] = 1
    matrix[3, 2:4] = sigma(OUTER) + SPRINGS * u(OUTER)
    matrix[4] = [*u(MIDDLE), *-u(MIDDLE), -1 / c_n]
    return float(np.linalg.solve(matrix, right)[4])


def normal_force(pressure):
    """Force (N/m) of a uniform pressure around the contact of the rings."""
    return 2 * np.pi * MIDDLE * pressure


def shaft(backend, degree, k, clearance=2e-5):
    """Part of a shaft that is pressed into a bore of a radius larger by a clearance (m)."""
    inner = {"inner_radius": 0.03, "outer_radius": 0.07 - clearance, "start": 210.0, "end": 330.0}
    outer = {"inner_radius": 0.07, "outer_radius": 0.1, "start": 195.0, "end": 345.0}
    sector = {"shape": "ring_sector"}
    held = {"springs": [{"surface": "inner", "stiffness": [1e6, 1e6]}]}
    bodies = {
        "shaft": body(backend, sector | inner, (2 * k, 9 * k), degree, 2e10, **held),
        "bore": body(
            backend, sector | outer, (2 * k, 10 * k), degree, 2e10, supports=[{"surface": "outer"}]
        ),
    }
    contact = {"a": "shaft.outer", "b": "bore.inner", "formulation": MORTAR, "c_n": 1e12}
    return static(bodies, contact | {"mu": 0.0, "reach": 3e-3}, {
        "surface": "shaft.inner", "force": [0.0, -2e4]
    })  # fmt: skip


def in_files(data, folder):
    """The scene with its Lagrange bodies from mesh files that gmsh writes."""
    for name, each in read_scene(data).bodies.items():
        if each.backend == "fe":
            fe, file = each.mesh.fe, Path(folder) / f"{name}.msh"
            breaks = breaks_of(each.geometry, fe.elements)
            with gmsh_model(shape_mesh(each.geometry, fe.cell, fe.degree, breaks=breaks)):
                gmsh.write(str(file))
            geometry = {"shape": "mesh_file", "file": str(file), "unit": "m"}
            data["bodies"][name] |= {"geometry": geometry, "mesh": {}}
    return data


def pressed(data):
    """Result of a static scene, and the state of its contact."""
    result = run_static(read_scene(data))
    (state,) = result.steady.contacts.values()
    return result, state


def kinds(result):
    return {warning.kind: warning.data for warning in result.warnings}


PLACED = {"axis": [0.0, 0.0, 1.0], "angle": 37.0, "translation": [0.3, -0.2, 0.0]}


def interface(data):
    scene = read_scene(data)
    (found,) = build_interfaces(scene, build_bodies(scene, StageTimer()), StageTimer()).values()
    return found


@pytest.mark.parametrize(
    ("degree", "backends"),
    [(1, ("fe", "fe")), (2, ("fe", "iga")), (3, ("iga", "fe")), (4, ("fe", "fe"))],
)
def test_rings_that_touch_have_no_gap(degree, backends):
    data = rings(degree, ((1, 24), (1, 16)), backends)
    for each in data["bodies"].values():
        each["placement"] = PLACED
    found = interface(data)
    assert np.abs(found.initial_gap).max() < 1e-15
    assert found.largest_distance > {1: 3e-4, 2: 3e-7, 3: 1e-8, 4: 3e-11}[degree]


@pytest.mark.parametrize("degree", [1, 3])
def test_a_shaft_keeps_its_clearance(degree):
    """The distance of two circles along the lines on which facets are searched."""
    clearance = 2e-5
    found = interface(shaft("fe", degree, 1, clearance))
    x, n = found.points.x, found.points.normal
    across = np.einsum("ij,ij->i", x, n)
    beyond = (x**2).sum(axis=1) - across**2
    ends = [np.sqrt(radius**2 - beyond) for radius in (0.07 - clearance, 0.07)]
    np.testing.assert_allclose(found.initial_gap, ends[1] - ends[0], rtol=0, atol=1e-15)
    assert found.initial_gap.min() == pytest.approx(clearance, rel=1e-5)


@pytest.mark.parametrize(
    ("degree", "elements", "formulation"),
    [
        (1, ((2, 80), (2, 68)), MORTAR),
        (2, ((2, 20), (2, 16)), SEGMENTS),
        (3, ((2, 20), (2, 16)), MORTAR),
    ],
)
def test_rings_meet_the_pressure_of_lame(degree, elements, formulation):
    """The normal force always; the peak to two per cent, or with a warning."""
    result, state = pressed(rings(degree, elements, formulation=formulation))
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=2e-3)
    if abs(state.pressure.max() / lame() - 1) > 0.02:
        assert kinds(result)["geometry-error"]["relative"] > 0.01
    else:
        assert result.warnings == ()
        assert state.closed_fraction == 1
    assert result.warnings == () or formulation is SEGMENTS


@pytest.mark.parametrize("degree", [1, 2])
def test_gaps_that_a_mesh_file_cannot_tell_count_as_zero(degree, tmp_path):
    """Rings touch; their normal force is right, and it is said that nobody knows that they do."""
    data = in_files(rings(degree, ((2, 24), (2, 16))), tmp_path)
    result, state = pressed(data)
    assert state.normal_force == pytest.approx(normal_force(lame()), rel=5e-3)
    assert state.pressure.max() == pytest.approx(lame(), rel=0.02)
    found = kinds(result)
    assert found["gaps-as-zero"]["fraction"] == pytest.approx(1)
    assert 0 < found["gaps-as-zero"]["gap"] < found["gaps-as-zero"]["geometry_error"]
    closure = found["geometry-error"]["closure"]
    assert closure == pytest.approx(lame() / 1e12, rel=0.02)
    assert found["geometry-error"]["geometry_error"] > closure


def test_a_clearance_below_the_error_of_a_mesh_file_is_told(tmp_path):
    result, _ = pressed(in_files(shaft("fe", 1, 1), tmp_path))
    found = kinds(result)
    assert found["gaps-as-zero"]["geometry_error"] > 2e-5
    assert found["geometry-error"]["relative"] > 1
