"""Whether a state of steady sliding is alone, told by the tangent there.

The law of the pressure is monotone: without friction the tangent is symmetric positive definite and
there is one equilibrium. With friction it may become singular, where branches of equilibria meet,
and beyond it an odd number of its real eigenvalues is negative: the sign of its determinant tells.
Where bodies rotate beyond a critical rate the symmetric part has negative eigenvalues of its own:
it is those beyond them that count.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.pencil import Matrices
from cea.eigen.shifted import Shifted, count_below
from cea.eigen.static import rounding_uncertainty
from cea.errors import ConvergenceError
from cea.matrices import destroy
from cea.system.sliding_state import Uniqueness

_STEPS = 12
"""Inverse iterations."""
_LOST = 0.1
"""Rounding, relative to the largest displacement, at which a tangent counts as singular."""


def uniqueness_at(
    tangent: Matrices,
    x: Floats,
    f: Floats,
    parities: Mapping[float, int | None],
    *,
    unstable: bool,
) -> tuple[Uniqueness | None, float | None]:
    """What a tangent says of other equilibria, and what rounding makes of the displacements.

    Parameters
    ----------
    tangent
        The tangent in the state.
    x, f
        Displacements and contact forces that are unknowns there, the rows of this rank.
    parities
        Parity of negative eigenvalues on the way, by part of the load.
    unstable
        Whether the bodies are not stable without contacts.

    Returns
    -------
    tuple
        None for the first of a symmetric tangent; None for the second of a singular one.
    """
    try:
        factors = Shifted(tangent)
    except ConvergenceError:
        return None, None
    uncertainty = rounding_uncertainty(tangent, factors, x[:, None], f[:, None])
    found = None
    if not tangent.symmetric:
        parity = parity_beside(tangent, factors, unstable=unstable)
        found = Uniqueness(parity, parities, _margin(tangent, factors))
    factors.free()
    return found, uncertainty if uncertainty < _LOST else None


def parity_beside(tangent: Matrices, factors: Shifted, *, unstable: bool) -> int | None:
    """Whether a tangent has an odd (1) or even (0) number of negative real eigenvalues.

    More than its symmetric part has, where that may have some; None where it is not known.

    Parameters
    ----------
    tangent, factors
        The tangent, and factorised.
    unstable
        Whether the bodies are not stable without contacts.
    """
    parity = factors.parity()
    if parity is None or not unstable:
        return parity
    return (parity + count_below(tangent, 0.0)) % 2


def _margin(tangent: Matrices, factors: Shifted) -> float:
    """Inverse of the growth of A^-1 S, S the symmetric part of A that contact and bodies make."""
    S = tangent.stiffness
    x, y = S.createVecRight(), S.createVecLeft()
    x.array[:] = np.random.default_rng(S.comm.rank).standard_normal(x.getLocalSize())
    growths = []
    for _ in range(_STEPS):
        S.mult(x, y)
        before = _norm(x)
        factors.solve(y, x)
        growths.append(_norm(x) / before)
        x.scale(1 / _norm(x))
    destroy(x, y)
    late = np.array(growths[_STEPS // 2 :])
    return float(1 / np.exp(np.log(late).mean()))


def _norm(x: Any) -> float:
    return float(x.norm())
