"""Memory that scenes take, and what becomes of those for which there is none.

What factors take MUMPS tells once matrices are there (:class:`cea.eigen.mumps.NoRoomError`): where
memory would not do they go to disk, or the scene is refused. Only what the matrices alone would not
fit into is refused before work starts.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf, prod
from shutil import disk_usage
from tempfile import gettempdir
from typing import Any

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.mumps import NoRoomError, factors_on_disk, free_memory
from cea.errors import InputError, ResultWarning
from cea.petsc import MPI, give_back
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh
from scenes.spec.reading import Scene

_MATRICES, _ENTRY = 4, 12
"""Stiffness matrices that are alive at once at least, and bytes of an entry of one."""


def dofs_of(body: BodySpec) -> float:
    """Estimate of the unknowns of a body, supports not taken out."""
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
    inner = np.zeros((1, dim))  # knots that a geometry brings along
    if isinstance(given, Patches):
        knots = [[len(k) for k in patch.knots] for patch in given.patches]
        inner = np.array(knots) - 2 * np.array([patch.degrees for patch in given.patches]) - 2
    p, c = np.array(mesh.degree), np.array(mesh.continuities)
    counts = (p - c) * (np.array(mesh.elements) + inner) + c + 1.0
    return dim * float(counts.prod(axis=1).sum())


def check_memory(scene: Scene, comm: Any = MPI.COMM_WORLD) -> None:
    """Refuse a scene whose matrices alone do not fit into the memory of all ranks; collective."""
    give_back()  # what the process has freed
    free, dofs = comm.size * free_memory(comm), {n: dofs_of(b) for n, b in scene.bodies.items()}
    rows = {name: body.dim * (body.degree + 2.0) ** body.dim for name, body in scene.bodies.items()}
    needed = _MATRICES * _ENTRY * sum(dofs[name] * rows[name] for name in dofs)
    if needed > free:
        told = f"matrices of {sum(dofs.values()):.3g} dofs take {needed / 1e9:.3g} GB or more"
        raise _refusal(scene, f"{told} of the {free / 1e9:.3g} GB there are")


def _refusal(scene: Scene, told: str) -> InputError:
    """The refusal of the mesh of the largest body."""
    name, body = max(scene.bodies.items(), key=lambda item: dofs_of(item[1]))
    mesh = body.division
    field, value = f"bodies.{name}.geometry.file", getattr(body.geometry, "file", None)
    if mesh is not None:
        kind = "elements" if mesh.elements is not None else "size"
        field, value = f"bodies.{name}.mesh.{body.backend}.{kind}", getattr(mesh, kind)
    return InputError(field, value, f"a mesh that fits into memory: {told}")


@contextmanager
def factors_of(scene: Scene) -> Iterator[None]:
    """Refuse a scene for whose factors there is no memory, by the field of its mesh."""
    try:
        yield
    except NoRoomError as error:
        raise _refusal(scene, str(error)) from error


def in_memory_or_on_disk[T](
    scene: Scene, driver: EigenSolver, solve: Callable[[], T]
) -> tuple[T, tuple[ResultWarning, ...]]:
    """What a driver solves, with factors on disk where memory would not do; collective.

    What it returns must be read with the warnings.
    """
    try:
        return solve(), ()
    except NoRoomError as error:
        lack = error
    driver.free()
    disk = driver.pencil.comm.tompi4py().allreduce(free_disk(), MPI.MIN)
    files = f"{lack.files / 1e9:.3g} GB of factors"
    if lack.files > disk:
        told = f"{lack}; {files} on disk, where {disk / 1e9:.3g} GB are free"
        raise _refusal(scene, told) from lack
    with factors_of(scene), factors_on_disk():
        try:
            found = solve()
        finally:
            driver.free()
    data = {"memory": lack.memory, "available": lack.free, "files": lack.files}
    data["memory_with_files"] = lack.with_files
    return found, (ResultWarning("factors-on-disk", f"{files} were on disk: {lack}", data),)


def free_disk() -> float:
    """Bytes that are free where temporary files go."""
    return float(disk_usage(gettempdir()).free)
