"""Memory that a scene needs, estimated before work starts, and whether the machine has it.

The factors of the stiffness take most of it. Their size is that of nested dissection: a box of
nodes is cut in halves across its longest direction, again and again, and each cut becomes a dense
front of its own nodes beside those around its box that were cut before.
"""

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from math import factorial, inf, prod
from pathlib import Path
from shutil import disk_usage
from tempfile import gettempdir
from typing import Any

import numpy as np

from cea.eigen.mumps import factors_on_disk
from cea.errors import InputError, ResultWarning
from cea.mesh import SIMPLICES
from cea.petsc import MPI, give_back
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile, Patches
from meshes.shapes import VentilatedDisc
from scenes.spec.body import BodySpec
from scenes.spec.reading import Scene

_NUMBER, _ENTRY = 8, 12
"""Bytes of a number, and of an entry of a sparse matrix with its column."""
_MATRICES = 7.0
"""Matrices alive at once, in stiffness matrices: of the bodies, of the system, their copies."""
_FACTORS, _SYMMETRIC = 1.6, 0.6
"""Memory of the factors with the room they are made in, relative to their entries; and the part of
it that those of a symmetric matrix take."""
_ON_DISK = 0.35
"""Part of the factors that is in memory at once where the rest is on disk: the largest fronts."""
_VECTORS, _QUADRATIC = 600.0, 4.0
"""Vectors in Krylov spaces, and their entries in a damped or rotating system relative to those."""
_PROGRAM = 3e8
"""Bytes of the program itself."""
_SMALL = 4.0
"""Nodes along the longest side of a box that is not cut any more."""
_PART = 0.9
"""Part of the memory of a machine that a run may have."""


@dataclass(frozen=True)
class MemoryEstimate:
    """Memory that a scene needs on all ranks together.

    ``dofs`` are unknowns, ``factor_entries`` those of the factors of the stiffness; ``factors`` and
    ``others`` the bytes of the factors, and of all else.
    """

    dofs: float
    factor_entries: float
    factors: float
    others: float

    @property
    def bytes(self) -> float:
        """All of it (bytes)."""
        return self.factors + self.others

    @property
    def bytes_with_files(self) -> float:
        """All of it with the factors on disk (bytes)."""
        return _ON_DISK * self.factors + self.others


def estimated_memory(scene: Scene) -> MemoryEstimate:
    """Memory that a scene needs: 0.6 to 2 of the peak of runs that take more than 500 MB.

    What contact adds is not counted: it is large only where mortar or saddle meet a fine interface
    in space.
    """
    dofs = nonzeros = entries = 0.0
    for body in scene.bodies.values():
        dim, (near, width) = body.dim, _couplings(body)
        dofs += dofs_of(body)
        nonzeros += dim * dofs_of(body) * near**dim
        entries += dim**2 * sum(_dissected(counts, width) for counts in _node_counts(body))
    static = scene.analysis.kind == "static"
    quadratic = not static and (scene.damped or scene.rotates)
    unsymmetric = quadratic or scene.has_friction
    vectors = 0.0 if static else min(_VECTORS, dofs) * (_QUADRATIC if quadratic else 1.0)
    return MemoryEstimate(
        dofs,
        entries,
        _FACTORS * (1.0 if unsymmetric else _SYMMETRIC) * _NUMBER * entries,
        _PROGRAM + _MATRICES * _ENTRY * nonzeros + _NUMBER * vectors * dofs,
    )


def dofs_of(body: BodySpec) -> float:
    """Estimate of the unknowns of a body, supports not taken out."""
    return body.dim * sum(map(prod, _node_counts(body)))


def _node_counts(body: BodySpec) -> list[tuple[float, ...]]:
    """Nodes along each direction of boxes that stand for a mesh, one for each patch."""
    shape, fe, iga, lengths = body.geometry, body.mesh.fe, body.mesh.iga, body.lengths
    if isinstance(shape, MeshFile):
        own, dim = shape.elements, len(lengths)
        degree = body.fe_degree or own.order
        nodes = len(own.used) * (degree / own.order) ** dim
        if own.incomplete:
            cubes = own.num_cells / (factorial(dim) if own.is_divided else 1)
            nodes = max(nodes, cubes * degree**dim)
        even = (nodes / prod(lengths)) ** (1 / dim)
        return [tuple(max(1.0, even * length) for length in lengths)]
    if body.backend == "fe" and fe is not None:
        # boxes of the target edge length have about as many nodes as unstructured tetrahedra
        size = fe.size or inf
        if isinstance(shape, VentilatedDisc):
            size = shape.mean_size(size)
        along = fe.elements or [max(1.0, length / size) for length in lengths]
        return [tuple(fe.degree * n + 1.0 for n in along)]
    if iga is None:
        return []
    given = shape.given if isinstance(shape, NurbsFile) else shape
    inner = [[0] * len(lengths)]  # knots that a geometry brings along
    if isinstance(given, Patches):
        inner = [
            [len(k) - 2 * p - 2 for k, p in zip(patch.knots, patch.degrees, strict=True)]
            for patch in given.patches
        ]
    p, c = np.array(iga.degree), np.array(iga.continuities)
    counts = (p - c) * (np.array(iga.elements) + np.array(inner)) + c + 1.0
    return [tuple(patch) for patch in counts.tolist()]


def _couplings(body: BodySpec) -> tuple[float, float]:
    """Nodes along a direction that one is coupled to, and layers of them that part a body."""
    fe, iga = body.mesh.fe, body.mesh.iga
    if body.backend == "iga" and iga is not None:
        p, c = max(iga.degree), min(iga.continuities)
        return p + c + 2.0, c + 1.0
    simplices = fe is not None and fe.cell in SIMPLICES
    return ((body.fe_degree or 1) + 2.0) * (0.82 if simplices else 1.0), 1.0


def _dissected(box: tuple[float, ...], width: float) -> float:
    """Entries of the factors, L and U, of one unknown at each node of a box."""
    counts, entries, boxes = list(box), 0.0, 1.0
    cut = [0.0] * len(counts)
    while max(counts) > max(_SMALL, 2 * width):
        axis = counts.index(max(counts))
        faces = [width * prod(counts) / count for count in counts]
        around = sum(min(c, 2.0) * face for c, face in zip(cut, faces, strict=True))
        entries += boxes * faces[axis] * (faces[axis] + 2 * around)
        counts[axis] = 0.5 * (counts[axis] - width)
        cut[axis] += 1.0
        boxes *= 2
    rest = prod(counts)
    around = sum(min(c, 2.0) * width * rest / n for c, n in zip(cut, counts, strict=True))
    return entries + boxes * rest * (rest + 2 * around)


def available_memory() -> float:
    """Memory (bytes) that is free on the machine with what the program itself takes already.

    What the process is confined to counts where that is less.
    """
    give_back()  # what the process has freed
    lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    free = [1024 * float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
    limits = [each + _PROGRAM for each in free]
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    if soft != resource.RLIM_INFINITY:
        limits.append(float(soft))
    for file in ("memory.max", "memory/memory.limit_in_bytes"):
        with suppress(OSError, ValueError):  # no such group, or no limit
            limits.append(float((Path("/sys/fs/cgroup") / file).read_text()))
    return min(limits)


def free_disk() -> float:
    """Bytes that are free where temporary files go."""
    return float(disk_usage(gettempdir()).free)


def _on_all_machines(amount: Callable[[], float], comm: Any) -> float:
    """What a run may have of something that the machines of all ranks have; collective."""
    neighbours = comm.Split_type(MPI.COMM_TYPE_SHARED)
    available = _PART * comm.allreduce(amount() / neighbours.size)
    neighbours.Free()
    return float(available)


def check_memory(
    scene: Scene, comm: Any = MPI.COMM_WORLD, *, on_disk: bool = True
) -> tuple[ResultWarning, ...]:
    """Refuse a scene that cannot fit into the memory of the machines of all ranks; collective.

    Returns a warning where it fits with factors on disk alone, which those that modes are sought
    with may be.
    """
    available, estimate = _on_all_machines(available_memory, comm), estimated_memory(scene)
    if estimate.bytes <= available:
        return ()
    needed, there = _gigabytes(estimate.bytes), _gigabytes(available)
    told = f"{estimate.dofs:.3g} dofs take about {needed} of the {there} there are"
    if on_disk and scene.analysis.kind == "cea" and not scene.slides_steadily:
        disk = _on_all_machines(free_disk, comm)
        factors, rest = _gigabytes(estimate.factors), _gigabytes(estimate.bytes_with_files)
        if estimate.bytes_with_files <= available and estimate.factors <= disk:
            message = (
                f"about {factors} of factors were on disk: the scene takes {needed} of {there}"
            )
            data = {
                "memory": estimate.bytes,
                "available": available,
                "files": estimate.factors,
                "memory_with_files": estimate.bytes_with_files,
            }
            return (ResultWarning("factors-on-disk", message, data),)
        told += f", or {rest} with {factors} of factors on disk, where {_gigabytes(disk)} are free"
    name, body = max(scene.bodies.items(), key=lambda item: dofs_of(item[1]))
    mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
    field, value = f"bodies.{name}.geometry.file", getattr(body.geometry, "file", None)
    if mesh is not None:
        kind = "elements" if mesh.elements is not None else "size"
        field, value = f"bodies.{name}.mesh.{body.backend}.{kind}", getattr(mesh, kind)
    raise InputError(field, value, f"a mesh that fits into memory: {told}")


@contextmanager
def room_for_factors(scene: Scene) -> Iterator[tuple[ResultWarning, ...]]:
    """Keep factors on disk while this lasts, where memory would not do; collective.

    The result must be read with the warnings; the factors must be freed before it ends.
    """
    warnings = check_memory(scene)
    with factors_on_disk() if warnings else nullcontext():
        yield warnings


def _gigabytes(number: float) -> str:
    return f"{number / 1e9:.3g} GB"
