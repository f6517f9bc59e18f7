"""How the points of an interface suit the traces of its sides: too few of them, or too many.

A rule with fewer points than a side has trace functions leaves gaps that nothing resists. One with
more points than either side has, on meshes of which neither holds the other's traces, asks for a
closed gap more often than the traces can give, and locks as the stiffness grows. Traces are counted
split at corners, for there is a gap along the normal of each smooth part.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from cea.arrays import Floats
from cea.contact.interface import Interface

_HELD = 1e-6
"""Part of a trace that rounding, and the small shift below, may leave out of the other's."""
_SHIFT = 1e-12
_VANISHES = 1e-10  # value of a trace function that counts as zero


@dataclass(frozen=True)
class Sampling:
    """Points of an interface, and trace functions of each side where the sides meet."""

    points: int  # number of points
    # number of scalar trace functions of side a, or their part by area where it is not covered
    functions_a: int
    functions_b: int  # number of those of side b that points touch


def sampling(interface: Interface) -> Sampling:
    """Count points and trace functions; collective."""
    covered = min(1.0, float(interface.points.weight.sum()) / interface.a.area)
    functions = round(covered * len(np.unique(interface.a.functions)), 6)
    a, b = (len(_touched(interface, trace)) for trace in _traces(interface))
    return Sampling(len(interface.points), max(a, int(functions)), b)


def nested(interface: Interface) -> bool:
    """Whether one side has the traces of the other, as on meshes that match; collective."""
    comm = interface.comm
    traces = [
        csr_array(vstack(comm.allgather(csr_array(trace[:, _touched(interface, trace)]))))
        for trace in _traces(interface)
    ]
    a, b = traces
    weight = interface.points.weight
    return _holds(a, b, weight) or _holds(b, a, weight)


def _traces(interface: Interface) -> tuple[csr_array, csr_array]:
    """Trace functions of both sides, split at corners, at the points of this rank."""
    points, opposite = interface.local_points.at, interface.opposite.at
    return interface.a.split_trace(points), interface.b.split_trace(opposite)


def _touched(interface: Interface, trace: csr_array) -> np.ndarray:
    """Trace functions that do not vanish at all points, on some rank."""
    own = np.unique(trace.indices[np.abs(trace.data) > _VANISHES])
    return np.unique(np.concatenate(interface.comm.allgather(own)))


def _holds(one: csr_array, other: csr_array, weight: Floats) -> bool:
    """Whether a random function of the one lies in the traces of the other."""
    values = one @ np.random.default_rng(0).standard_normal(one.shape[1])
    weighted = diags_array(weight)
    gram = other.T @ weighted @ other
    shift = _SHIFT * gram.diagonal().max()
    solver = splu((gram + diags_array(np.full(other.shape[1], shift))).tocsc())
    rest = values - other @ solver.solve(other.T @ (weight * values))
    return bool(rest @ (weight * rest) <= _HELD**2 * (values @ (weight * values)))
