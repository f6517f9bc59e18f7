"""Memory that a scene needs, estimated before work starts, and whether the machine has it.

The factors of the stiffness take most of it. Their size is that of nested dissection: a box of
nodes is cut in halves across its longest direction, again and again, and each cut becomes a dense
front of its own nodes beside those around its box that were cut before.
"""

import os
import resource
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi, prod, sqrt
from pathlib import Path
from shutil import disk_usage
from tempfile import gettempdir
from typing import Any

from cea.errors import InputError
from cea.heap import give_back, kept
from cea.petsc import MPI
from meshes.mesh_file import MeshFile
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh
from scenes.spec.node_grids import TINY, NodeGrid, box_lengths, node_grids
from scenes.spec.reading import Scene

_NUMBER, _ENTRY = 8, 12
"""Bytes of a number, and of an entry of a sparse matrix with its column."""
_MATRICES = {"static": 4.0, "cea": 6.0}
"""Matrices alive at once, in stiffness matrices: of the bodies, of the system, their copies."""
_FACTORS = 1.6
"""Memory of the factors with the room they are made in, relative to their entries."""
_SYMMETRIC = 0.6
"""The same of a symmetric matrix, of which one factor is kept, relative to that of both."""
_ON_DISK = 0.35
"""Part of the factors that is in memory at once where the rest is on disk: the largest fronts."""
_FILES = 1.0
"""Bytes of factors on disk relative to those in memory: two sets of them for a while."""
_QUADRATIC = 4.0
"""Entries of the vectors of a damped or rotating system relative to those of a linear one: of
displacements and velocities, for each mode and its conjugate."""
_VELOCITIES = 2.0
"""Matrices of such a system that are alive beside those of a linear one, in stiffness matrices."""
_VECTORS = 6.0
"""Vectors held for each mode sought: a Krylov basis of twice the number, its restart, the modes."""
_MODAL, _UPDATE = 8.0, 48.0
"""Bytes for each mode that modal damping damps: for each dof of its body, M phi; for each dof of
all bodies, that once more, twice while it is solved for, and the complex solutions twice."""
_PROGRAM = 3e8
"""Bytes of the program itself."""
_FEWEST = 50
"""Modes that are made room for, at least."""
_SMALL = 4.0
"""Nodes along the longest side of a box that is not cut any more."""
_BISECTIONS = 40
_PART = 0.9
"""Part of the memory of a machine that a run may have."""


_LARGE = 0.25
"""Part of what a run may have from which on what the program has freed is given back before it."""


@dataclass(frozen=True)
class MemoryEstimate:
    """Memory that a scene needs, in its parts.

    Parameters
    ----------
    dofs
        Unknowns.
    nonzeros
        Entries of the stiffness matrix.
    factor_entries
        Entries of its factors.
    modes
        Modes that are made room for.
    matrices, factors, vectors, modal
        Bytes of each; the last are those of modal damping.
    """

    dofs: float
    nonzeros: float
    factor_entries: float
    modes: float
    matrices: float
    factors: float
    vectors: float
    modal: float = 0.0

    @property
    def bytes(self) -> float:
        """All of it, the program itself too (bytes)."""
        return _PROGRAM + self.matrices + self.factors + self.vectors + self.modal

    @property
    def bytes_with_files(self) -> float:
        """All of it with the factors on disk (bytes)."""
        return self.bytes - (1 - _ON_DISK) * self.factors

    @property
    def files(self) -> float:
        """The factors on disk (bytes)."""
        return _FILES * self.factors


def estimated_memory(scene: Scene, scale: float = 1.0) -> MemoryEstimate:
    """Memory that a scene needs on all ranks together.

    Parameters
    ----------
    scene
        The scene.
    scale
        Factor on the elements along each direction of every body.

    Notes
    -----
    Measured on both backends, in the plane and in space, with and without friction, from 9,000 to
    390,000 dofs: 0.8 to 1.7 of the peak of runs that take more than 500 MB. What contact adds is
    not counted: it is large only where mortar or saddle meet a fine interface in space.
    """
    dofs = nonzeros = entries = modes = damped = modal = 0.0
    for body in scene.bodies.values():
        dim, before = len(body.geometry.directions), dofs
        beside = 2 if _circulates(body) else 1  # matrices of what damping makes of displacements
        for grid in node_grids(body, scale):
            n = prod(grid.counts)
            dofs += dim * n
            nonzeros += beside * dim**2 * n * prod(grid.couplings)
            entries += dim**2 * _dissected(grid)
        if isinstance(scene.analysis, ComplexEigenvalueAnalysis):
            modes += _modes_below(scene.analysis.max_frequency, body)
            own = min(_damped_modes(body), dofs - before)
            damped, modal = damped + own, modal + _MODAL * own * (dofs - before)
    static = scene.analysis.kind == "static"
    modes = 1.0 if static else min(max(modes, _FEWEST), dofs)
    unsymmetric = any(contact.mu for contact in scene.contacts.values())
    quadratic = not static and (scene.damped or scene.rotates)
    kept = 1.0 if unsymmetric or quadratic else _SYMMETRIC
    alive = _MATRICES[scene.analysis.kind] + (_VELOCITIES if quadratic else 0.0)
    return MemoryEstimate(
        dofs,
        nonzeros,
        entries,
        modes,
        matrices=alive * _ENTRY * nonzeros,
        factors=_FACTORS * kept * _NUMBER * entries,
        vectors=_VECTORS * (_QUADRATIC if quadratic else 1.0) * _NUMBER * modes * dofs,
        modal=modal + _UPDATE * damped * dofs,
    )


def available_memory() -> float:
    """Memory (bytes) that is free on the machine with what the program itself takes already.

    What the process is confined to counts where that is less.
    """
    machine = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    limits = [machine, _free() + _PROGRAM, inf if soft == resource.RLIM_INFINITY else float(soft)]
    for file in ("memory.max", "memory/memory.limit_in_bytes"):
        try:
            limits.append(float((Path("/sys/fs/cgroup") / file).read_text()))
        except (OSError, ValueError):
            continue  # no such group, or no limit
    return min(limits)


def _free() -> float:
    """Memory (bytes) that no program holds now; infinite where the system does not tell.

    What this one has freed and kept counts as free.
    """
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return inf
    told = [float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
    return 1024 * told[0] + kept() if told else inf


def free_disk() -> float:
    """Bytes that are free where temporary files go."""
    return float(disk_usage(gettempdir()).free)


def on_all_machines(amount: Callable[[], float], comm: Any = MPI.COMM_WORLD) -> float:
    """What a run may have of something that the machines of all ranks have; collective."""
    neighbours = comm.Split_type(MPI.COMM_TYPE_SHARED)
    available = _PART * comm.allreduce(amount() / neighbours.size)
    neighbours.Free()
    return float(available)


def check_memory(scene: Scene, comm: Any = MPI.COMM_WORLD, *, on_disk: bool = True) -> None:
    """Refuse a scene that cannot fit into the memory of the machines of all ranks; collective.

    Parameters
    ----------
    scene
        The scene.
    comm
        Communicator (mpi4py) of the ranks that run it.
    on_disk
        Whether factors may be on disk (:mod:`scenes.running.factor_storage`).

    Raises
    ------
    InputError
        On every rank, naming the mesh that takes most, the estimate, what there is and what would
        fit.
    """
    available = on_all_machines(available_memory, comm)
    estimate = estimated_memory(scene)
    if estimate.bytes > _LARGE * available:  # what was freed may not do in one piece
        give_back()
    if estimate.bytes <= available:
        return
    disk = on_all_machines(free_disk, comm) if on_disk else 0.0
    if _fits_with_files(scene, estimate, available, disk):
        return
    name, body = max(scene.bodies.items(), key=lambda item: _nodes(item[1]))
    told = (
        f"{estimate.dofs:.3g} dofs take about {_gigabytes(estimate.bytes)} of the "
        f"{_gigabytes(available)} there are"
    )
    if on_disk and may_be_on_disk(scene):
        told += (
            f", or {_gigabytes(estimate.bytes_with_files)} with {_gigabytes(estimate.files)} of "
            f"factors on disk, where {_gigabytes(disk)} are free"
        )
    if isinstance(body.geometry, MeshFile):
        field = f"bodies.{name}.geometry.file"
        raise InputError(field, body.geometry.file, f"a mesh that fits into memory: {told}")
    scale = _fitting_scale(scene, available, disk)
    field, value, fitting = _mesh_of(body, scale)
    would = f"{field} = {fitting} would, the other bodies coarser alike" if scale else "none would"
    raise InputError(
        f"bodies.{name}.mesh.{body.backend}.{field}",
        value,
        f"a mesh that fits into memory: {told}; {would}",
    )


def may_be_on_disk(scene: Scene) -> bool:
    """Whether factors of a scene may be on disk: those that modes are sought with."""
    return isinstance(scene.analysis, ComplexEigenvalueAnalysis) and not scene.slides_steadily


def _fits_with_files(scene: Scene, estimate: MemoryEstimate, available: float, disk: float) -> bool:
    fits = estimate.bytes_with_files <= available and estimate.files <= disk
    return may_be_on_disk(scene) and fits


def _fitting_scale(scene: Scene, available: float, disk: float) -> float:
    """Largest factor on all elements with which a scene fits, 0 where none does."""
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        estimate = estimated_memory(scene, middle)
        fits = estimate.bytes <= available or _fits_with_files(scene, estimate, available, disk)
        low, high = (middle, high) if fits else (low, middle)
    return low


def _mesh_of(body: BodySpec, scale: float) -> tuple[str, object, object]:
    """Field that says how fine a body is, its value, and its value on a coarser mesh."""
    mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
    if isinstance(mesh, FeMesh) and mesh.size is not None:
        return "size", mesh.size, float(f"{mesh.size / max(scale, TINY):.3g}")
    elements = () if mesh is None else mesh.elements or ()
    return "elements", elements, tuple(max(1, int(scale * n)) for n in elements)


def _gigabytes(number: float) -> str:
    return f"{number / 1e9:.3g} GB"


def _nodes(body: BodySpec) -> float:
    return sum(prod(grid.counts) for grid in node_grids(body, 1.0))


def _dissected(grid: NodeGrid) -> float:
    """Entries of the factors, L and U, of one unknown at each node of a box."""
    counts, entries, boxes = list(grid.counts), 0.0, 1.0
    cut = [0.0] * len(counts)
    while max(counts) > _SMALL:
        axis = max(range(len(counts)), key=lambda i: counts[i] / grid.widths[i])
        if counts[axis] <= 2 * grid.widths[axis]:
            break
        faces = [grid.widths[i] * prod(counts) / counts[i] for i in range(len(counts))]
        around = sum(min(cut[i], 2.0) * faces[i] for i in range(len(counts)))
        front = faces[axis]
        entries += boxes * front * (front + 2 * around)
        counts[axis] = 0.5 * (counts[axis] - grid.widths[axis])
        cut[axis] += 1.0
        boxes *= 2
    rest = prod(counts)
    around = sum(min(cut[i], 2.0) * grid.widths[i] * rest / counts[i] for i in range(len(counts)))
    return entries + boxes * rest * (rest + 2 * around)


def _modes_below(frequency: float, body: BodySpec) -> float:
    """Modes of a body below a frequency (Hz) by Weyl's law, each kind of wave on its own."""
    lengths, material = box_lengths(body.geometry), body.material
    lam, shear = material.lame
    rho = material.rho or 1.0
    kinds = [((lam + 2 * shear) / rho, 1), (shear / rho, len(lengths) - 1)]
    ball = pi if len(lengths) == 2 else 4 * pi / 3
    return sum(
        count * ball * prod(2 * frequency * length / sqrt(square) / 2 for length in lengths)
        for square, count in kinds
    )


def _circulates(body: BodySpec) -> bool:
    """Whether damping in proportion to the stiffness rotates with a body."""
    rayleigh = body.damping.rayleigh() if body.damping else None
    turns = body.rotation is not None and body.rotation.rate != 0
    return turns and rayleigh is not None and rayleigh.beta != 0


def _damped_modes(body: BodySpec) -> float:
    """Modes of a body that modal damping damps."""
    modal = body.damping.modal if body.damping else None
    if modal is None or not modal.acts:
        return 0.0
    return len(modal.ratios or ()) if modal.end is None else _modes_below(modal.end, body)
