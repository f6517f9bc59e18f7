"""Memory that scenes need: refusal of scenes that do not fit, and factors on disk.

MUMPS estimates the memory of the factors from the matrices
(:class:`cea.eigen.mumps.NoRoomError`). If it is not available, the factors are written to disk, or
the scene is refused. Before assembly, only scenes whose matrices alone do not fit are refused.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import inf, prod
from shutil import disk_usage
from tempfile import gettempdir
from typing import Any

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.mumps import NoRoomError, factors_on_disk, free_memory
from cea.errors import InputError, ResultWarning
from cea.petsc import MPI, give_back
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from scenes.spec.body import BodySpec, FeMesh
from scenes.spec.reading import Scene

_MATRICES, _ENTRY = 4, 12
"""Least number of stiffness matrices held at the same time, and bytes per stored entry."""


def dofs_of(body: BodySpec) -> float:
    """Estimate the number of unknowns of a body, including supported ones."""
    shape, mesh, dim = body.geometry, body.division, body.dim
    if isinstance(shape, MeshFile):
        own = shape.elements
        degree = body.fe_degree or own.order
        return dim * len(own.used) * (degree / own.order) ** dim
    if isinstance(mesh, FeMesh):
        # boxes of the target edge length have about as many nodes as unstructured tetrahedra
        along = mesh.elements or [max(1.0, length / (mesh.size or inf)) for length in body.lengths]
        return dim * prod(mesh.degree * n + 1.0 for n in along)
    if mesh is None:
        return 0.0
    given = shape.given if isinstance(shape, NurbsFile) else shape
    inner = np.zeros((1, dim))  # inner knots of the given geometry
    if isinstance(given, Patches):
        knots = [[len(k) for k in patch.knots] for patch in given.patches]
        inner = np.array(knots) - 2 * np.array([patch.degrees for patch in given.patches]) - 2
    p, c = np.array(mesh.degree), np.array(mesh.continuities)
    counts = (p - c) * (np.array(mesh.elements) + inner) + c + 1.0
    return dim * float(counts.prod(axis=1).sum())


def check_memory(scene: Scene, comm: Any = MPI.COMM_WORLD) -> None:
    """Raise an InputError if the matrices alone do not fit into memory; collective."""
    give_back()  # freed memory, to the system
    free, dofs = comm.size * free_memory(comm), {n: dofs_of(b) for n, b in scene.bodies.items()}
    rows = {name: body.dim * (body.degree + 2.0) ** body.dim for name, body in scene.bodies.items()}
    needed = _MATRICES * _ENTRY * sum(dofs[name] * rows[name] for name in dofs)
    if needed > free:
        told = f"matrices of {sum(dofs.values()):.3g} dofs need at least {needed / 1e9:.3g} GB"
        raise _refusal(scene, f"{told}, and {free / 1e9:.3g} GB are free")


def _refusal(scene: Scene, told: str) -> InputError:
    """Return the error that refuses a scene, with the mesh of its largest body as the field."""
    name, body = max(scene.bodies.items(), key=lambda item: dofs_of(item[1]))
    mesh = body.division
    field, value = f"bodies.{name}.geometry.file", getattr(body.geometry, "file", None)
    if mesh is not None:
        kind = "elements" if mesh.elements is not None else "size"
        field, value = f"bodies.{name}.mesh.{body.backend}.{kind}", getattr(mesh, kind)
    return InputError(field, value, f"a mesh that fits into memory: {told}")


@contextmanager
def factors_of(scene: Scene) -> Iterator[None]:
    """Convert a NoRoomError to an InputError that names the field of the mesh."""
    try:
        yield
    except NoRoomError as error:
        raise _refusal(scene, str(error)) from error


def in_memory_or_on_disk(scene: Scene, driver: EigenSolver, solve: Callable[[], Modes]) -> Modes:
    """Solve, with factors on disk and a warning if they do not fit into memory; collective.

    Raises an InputError if the factors do not fit on the disk either.
    """
    try:
        return solve()
    except NoRoomError as error:
        lack = error
    driver.free()
    disk = driver.pencil.comm.tompi4py().allreduce(free_disk(), MPI.MIN)
    files = f"{lack.files / 1e9:.3g} GB of factors"
    if lack.files > disk:
        told = f"{lack}; {files} do not fit on the disk, which has {disk / 1e9:.3g} GB free"
        raise _refusal(scene, told) from lack
    with factors_of(scene), factors_on_disk():
        try:
            modes = solve()
        finally:
            driver.free()
    data = {"memory": lack.memory, "available": lack.free, "files": lack.files}
    data["memory_with_files"] = lack.with_files
    warning = ResultWarning("factors-on-disk", f"{files} were written to disk: {lack}", data)
    return replace(modes, warnings=(*modes.warnings, warning))


def free_disk() -> float:
    """Return the free bytes of the file system of temporary files."""
    return float(disk_usage(gettempdir()).free)
