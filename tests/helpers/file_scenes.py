"""Scenes whose bodies come from mesh files, beside the same of built-in shapes."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mesh_writers import write

from cea.petsc import MPI
from meshes.breaks import breaks_of
from meshes.shape_mesh import shape_mesh
from scenes import run_modes
from scenes.spec.plain import plain_data
from scenes.spec.reading import load_scene, read_scene

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


def on_any_number_of_ranks():
    """Eigenvalues of a pair from a deck of 20-node hexahedra, and a refusal, on every rank."""
    comm = MPI.COMM_WORLD
    folder = TemporaryDirectory() if comm.rank == 0 else None
    path = comm.bcast(folder.name if folder else None, root=0)
    scene = built("hexahedron", 2)
    file = Path(path) / "pair.inp"
    data = from_file(scene, file, lacking=True) if comm.rank == 0 else None
    data = comm.bcast(data, root=0)
    found = eigenvalues(read_scene(data))
    data["bodies"]["upper"]["geometry"]["faces"]["y_min"] = "upper:S1"
    try:
        run_modes(read_scene(data))
        told = "accepted"
    except ValueError as error:
        told = str(error)
    every = comm.gather((found.tolist(), told), root=0)
    if folder is not None:
        folder.cleanup()
        assert all(told == every[0][1] for _, told in every)
    return {"re": found.real.tolist(), "im": found.imag.tolist(), "told": told}
