"""How the points of an interface suit the traces of its sides: too few of them, or too many.

A rule with fewer points than a side has trace functions leaves gaps that nothing resists. One with
more points than either side has, on meshes of which neither holds the other's traces, asks for a
closed gap more often than the traces can give, and locks as the stiffness grows.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from cea.body import Floats
from cea.contact.interface import Interface

_HELD = 1e-6
"""Part of a trace that rounding, and the small shift below, may leave out of the other's."""
_SHIFT = 1e-12


@dataclass(frozen=True)
class Sampling:
    """Points of an interface, and trace functions of each side that they touch.

    Parameters
    ----------
    points
        Number of points.
    functions_a, functions_b
        Number of scalar trace functions of each side that do not vanish at all points.
    """

    points: int
    functions_a: int
    functions_b: int


def sampling(interface: Interface) -> Sampling:
    """Count points and the trace functions they touch; collective."""
    return Sampling(
        len(interface.points),
        len(_touched(interface, interface.trace_a)),
        len(_touched(interface, interface.trace_b)),
    )


def nested(interface: Interface) -> bool:
    """Whether one side's traces hold those of the other, as on meshes that match; collective.

    A random function of each side is fitted, at the points, by the traces of the other.
    """
    comm = interface.comm
    traces = [
        csr_array(vstack(comm.allgather(csr_array(trace[:, _touched(interface, trace)]))))
        for trace in (interface.trace_a, interface.trace_b)
    ]
    a, b = traces
    weight = interface.points.weight
    return _holds(a, b, weight) or _holds(b, a, weight)


def _touched(interface: Interface, trace: csr_array) -> np.ndarray:
    """Trace functions that are not zero at some point on some rank."""
    own = np.unique(trace.indices[trace.data != 0])
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
