"""Scenes whose bodies come from mesh files, beside the same of built-in shapes."""

from pathlib import Path

import numpy as np
from mesh_writers import write

from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from scenes import run_modes
from scenes.spec.plain import plain_data
from scenes.spec.reading import load_scene

ELEMENTS = {"upper": (2, 1, 2), "lower": (4, 2, 2)}
TOP = {1: 0.36, 2: 0.25}
"""Upper end of the window (Hz), by degree."""


def built(cell, degree):
    """The blocks of the catalogue on coarse meshes; their nodes have few binary digits."""
    meshes = [
        f"bodies.{name}.mesh.fe={{cell = '{cell}', degree = {degree}, elements = {list(elements)}}}"
        for name, elements in ELEMENTS.items()
    ]
    settings = [*meshes, f"analysis.max_frequency={TOP[degree]}", "contacts.interface.mu=1.5"]
    return load_scene("blocks_3d", settings, backend="fe")


def from_file(scene, file, lacking=False, bodies=("upper", "lower")):
    """Plain data of a scene with bodies from one file that has their meshes, written here."""
    meshes = {}
    for name in bodies:
        geometry, fe = scene.bodies[name].geometry, scene.bodies[name].mesh.fe
        breaks = breaks_of(geometry, fe.elements)
        meshes[name] = shape_mesh(geometry, fe.cell, fe.degree, breaks=breaks)
    data = plain_data(scene)
    for name, geometry in write(meshes, Path(file), lacking).items():
        data["bodies"][name] |= {"geometry": geometry, "mesh": {}}
    return data


def eigenvalues(scene):
    """Eigenvalues of a scene, sorted."""
    found = run_modes(scene).modes.eigenvalues
    return found[np.lexsort((found.real.round(9), found.imag.round(9)))]
