"""Round bodies pressed together through a law of the gap, and what theory says of them."""

from pathlib import Path

import gmsh
import numpy as np
from gmsh_models import gmsh_model

from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from scenes import run_static
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
        **{"name": "curved", "bodies": bodies, "contacts": {"s": contact}, "loads": [load]},
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
