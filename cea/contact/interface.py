"""A contact interface: a point rule on surface a, located on surface b, and its operators.

With n the outward unit normal of a and k the direction of the friction traction on a,

    G = [n.N_a, -n.N_b]     gap operator (points x full dofs), penetration positive
    T = [k.N_a, -k.N_b]     slip operator

A rule with fewer points than a side has trace functions leaves gaps without resistance. A rule with
more points than either side has, on meshes of which neither contains the other's traces, has more
constraints than the traces can satisfy, and locks as the stiffness grows (:func:`sampling`). Traces
are counted after splitting at corners, since each smooth part has its own normal.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from cea.arrays import Floats
from cea.errors import require
from cea.petsc import MPI
from cea.ranks import agreed, local_rows
from cea.surface import Surface
from cea.surface_points import Location, Status, SurfacePoints

_QUADRATURE = 1e-3
"""Part of side a's area that quadrature errors may miss; a larger part counts as left out."""
_APART = 1e-3
"""Gap, relative to the mesh size, up to which sides with opposite normals touch."""
_SAGITTA = 0.25
"""Gap, relative to the mesh size times the largest angle between normals, due to faceting.

A chord of length h that makes the angle t with its arc at the ends has the sagitta h t / 4;
between the chords of two sides the normals differ by the sum of both angles.
"""
_FACING = -0.5  # largest cosine between the normals of facing surfaces
_HELD = 1e-6
"""Relative projection error, due to rounding and the shift below, of a contained trace."""
_SHIFT = 1e-12
_VANISHES = 1e-10  # value of a trace function below which it is treated as zero


@dataclass(frozen=True)
class Interface:
    """Points of a rule on side a paired with side b.

    All ranks hold all points; each rank locates and evaluates its own rows of them.
    """

    a: Surface
    b: Surface
    points: SurfacePoints  # points of the rule on a that were located on b, on all ranks
    rows: slice  # rows of the points of this rank, contiguous in rank order
    opposite: Location  # location of this rank's points on b along the normal of a
    # values of the scalar basis functions of both sides at the points of this rank
    trace_a: csr_array
    trace_b: csr_array
    statuses: Mapping[str, int]  # number of points of each status, including missed ones
    largest_distance: float  # largest distance of the meshed sides along the normal (m)
    comm: Any  # MPI communicator (mpi4py)

    @cached_property
    def geometry_error(self) -> Floats:
        """Estimated error (m) of :attr:`true_distance` at the points of this rank."""
        error_a = self.a.geometry_error(self.local_points.at)
        return error_a + self.b.geometry_error(self.opposite.at)

    @cached_property
    def true_distance(self) -> Floats:
        """Distance (m) from side a to side b along the normal at the points of this rank.

        Measured between the exact surfaces: where curved sides touch, facets may not.
        """
        normal = self.local_points.normal
        offset_a = self.a.offset(self.local_points.at, normal)
        return self.opposite.distance + self.b.offset(self.opposite.at, normal) - offset_a

    @property
    def initial_gap(self) -> Floats:
        """True distance (m); zero where it does not exceed the geometry error."""
        distance = self.true_distance
        return np.where(np.abs(distance) > self.geometry_error, distance, 0.0)

    @property
    def local_points(self) -> SurfacePoints:
        """Points of this rank."""
        return self.points[self.rows]


def default_reach(a: Surface, b: Surface) -> float:
    """Return the default reach (m), half the larger mesh size."""
    return 0.5 * max(a.mesh_size, b.mesh_size)


def pair(
    a: Surface,
    b: Surface,
    points: SurfacePoints,
    *,
    field: str = "contact",
    reach: float | None = None,
    max_missed: float = 0.0,
    comm: Any = MPI.COMM_WORLD,
) -> Interface:
    """Locate the points of a rule on side a on the surface of side b; collective.

    All ranks have the same points; those of weight zero are dropped. Points are located within
    ``reach`` (m) along the normal; by default within half the larger mesh size, and then the gap
    must not exceed that due to faceting of curved surfaces. Missed points are dropped if their
    fraction of the area of a is at most ``max_missed``. Raise InputError on every rank, naming
    ``field``, if a weight is negative, too many points are missed, or sides do not face or touch.
    """
    must_touch, sides = reach is None, f"{a.name} on {b.name}"
    if reach is None:
        reach = default_reach(a, b)
    _check_weights(points.weight, field)
    if not points.weight.all():
        points = points[points.weight > 0]
    start, stop = local_rows(len(points), comm)
    with agreed(comm):
        opposite = b.locate(points.x[start:stop], points.normal[start:stop], reach)
    status = np.concatenate(comm.allgather(opposite.status))
    found = status != Status.MISSED
    left_out = 1 - points.weight.sum() / a.area
    missed_area = points.weight[~found].sum() / a.area
    fraction = float(missed_area + (left_out if left_out > _QUADRATURE else 0.0))
    allowed = (
        f"surfaces that face each other within {reach:.3g} m: points on {100 * fraction:.2g} % "
        f"of the area of side a have no opposite point on side b, the limit is "
        f"{100 * max_missed:.2g} %; refine the mesh, or raise max_missed"
    )
    require(fraction <= max_missed, field, sides, allowed)
    if not found.all():
        points, opposite = points[found], opposite[found[start:stop]]
    rows = slice(*(int(found[:end].sum()) for end in (start, stop)))
    with agreed(comm):
        cosine = np.einsum("ij,ij->i", points.normal[rows], b.normal(opposite.at))
        trace_a, trace_b = a.trace(points.at[rows]), b.trace(opposite.at)
    worst = comm.allreduce(float(cosine.max(initial=-np.inf)), MPI.MAX)
    allowed = f"the cosine of their outward normals must be at most {_FACING}, not {worst:.3g}"
    facing = bool(len(points)) and worst <= _FACING
    require(facing, field, sides, f"surfaces that face each other: {allowed}")
    least = comm.allreduce(float(opposite.distance.min(initial=np.inf)), MPI.MIN)
    largest = comm.allreduce(float(opposite.distance.max(initial=-np.inf)), MPI.MAX)
    if must_touch:
        _check_gap((least, largest), worst, max(a.mesh_size, b.mesh_size), field, sides)
    return Interface(
        a=a,
        b=b,
        points=points,
        rows=rows,
        opposite=opposite,
        trace_a=trace_a,
        trace_b=trace_b,
        statuses={s.name.lower(): int((status == s).sum()) for s in Status},
        largest_distance=max(abs(least), abs(largest)),
        comm=comm,
    )


def along(trace: csr_array, direction: Floats) -> csr_array:
    """Return the displacement component along a direction, shape (n, dim * num_scalar_dofs).

    Components that are zero at every point are not stored.
    """
    (n, m), dim = trace.shape, direction.shape[1]
    acting = np.flatnonzero(direction.any(axis=0)).astype(trace.indices.dtype)
    part = np.repeat(direction[:, acting], np.diff(trace.indptr), axis=0)
    part *= trace.data[:, None]
    columns = trace.indices[:, None] * dim + acting
    return csr_array((part.ravel(), columns.ravel(), trace.indptr * len(acting)), (n, m * dim))


def _check_weights(weights: Floats, field: str) -> None:
    """Raise InputError if area weights are negative or not finite, as sqrt(D) is needed."""
    wrong = weights[~(np.isfinite(weights) & (weights >= 0))]
    valid = not len(wrong) and (not len(weights) or bool(weights.any()))
    value, place = float(wrong[0]) if len(wrong) else 0.0, f"{field}.formulation.weights"
    allowed = "nonnegative area weights of points, some of them positive"
    require(valid, place, value, allowed)


def _check_gap(
    distances: tuple[float, float], cosine: float, size: float, field: str, sides: str
) -> None:
    """Raise InputError if surfaces without a given reach are apart or overlap (negative)."""
    least, largest = distances
    angle = float(np.arccos(np.clip(-cosine, -1.0, 1.0)))
    explained = (_APART + _SAGITTA * angle) * size
    found = [f"{largest:.3g} m apart"] if largest > explained else []
    found += [f"{-least:.3g} m inside each other"] if -least > explained else []
    allowed = (
        f"given if surfaces do not touch: {sides} is up to {' and '.join(found)}, tilted by "
        f"up to {np.degrees(angle):.2g} degrees, and faceting accounts for {explained:.3g} m only"
    )
    require(not found, f"{field}.reach", None, allowed)


@dataclass(frozen=True)
class Sampling:
    """Points of an interface, and trace functions of each side where the sides meet."""

    points: int  # number of points
    # number of scalar trace functions of side a, scaled by the covered fraction of its area
    functions_a: int
    functions_b: int  # number of those of side b that are nonzero at a point


def sampling(interface: Interface) -> Sampling:
    """Count points and trace functions; collective."""
    covered = min(1.0, float(interface.points.weight.sum()) / interface.a.area)
    functions = round(covered * len(np.unique(interface.a.functions)), 6)
    a, b = (len(_touched(interface, trace)) for trace in _traces(interface))
    return Sampling(len(interface.points), max(a, int(functions)), b)


def nested(interface: Interface) -> bool:
    """Return whether one side contains the other's traces, as on matching meshes; collective."""
    comm = interface.comm
    traces = [
        csr_array(vstack(comm.allgather(csr_array(trace[:, _touched(interface, trace)]))))
        for trace in _traces(interface)
    ]
    a, b = traces
    weight = interface.points.weight
    return _holds(a, b, weight) or _holds(b, a, weight)


def _traces(interface: Interface) -> tuple[csr_array, csr_array]:
    """Return the trace functions of both sides, split at corners, at the points of this rank."""
    points, opposite = interface.local_points.at, interface.opposite.at
    return interface.a.split_trace(points), interface.b.split_trace(opposite)


def _touched(interface: Interface, trace: csr_array) -> np.ndarray:
    """Return the trace functions that are nonzero at a point of any rank."""
    own = np.unique(trace.indices[np.abs(trace.data) > _VANISHES])
    return np.unique(np.concatenate(interface.comm.allgather(own)))


def _holds(one: csr_array, other: csr_array, weight: Floats) -> bool:
    """Return whether a random function of ``one`` lies in the span of ``other``."""
    values = one @ np.random.default_rng(0).standard_normal(one.shape[1])
    weighted = diags_array(weight)
    gram = other.T @ weighted @ other
    shift = _SHIFT * gram.diagonal().max()
    solver = splu((gram + diags_array(np.full(other.shape[1], shift))).tocsc())
    rest = values - other @ solver.solve(other.T @ (weight * values))
    return bool(rest @ (weight * rest) <= _HELD**2 * (values @ (weight * values)))
