"""Number of points of an interface compared with the traces of its sides: too few or too many.

A rule with fewer points than a side has trace functions leaves gaps without resistance. A rule with
more points than either side has, on meshes of which neither contains the other's traces, has more
constraints than the traces can satisfy, and locks as the stiffness grows. Traces are counted after
splitting at corners, since each smooth part has its own normal.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from cea.arrays import Floats
from cea.contact.interface import Interface

_HELD = 1e-6
"""Relative projection error, due to rounding and the shift below, of a contained trace."""
_SHIFT = 1e-12
_VANISHES = 1e-10  # value of a trace function below which it is treated as zero


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
