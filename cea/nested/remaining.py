"""What is left of errors of eigenvalues after steps that converge, by what the last one changed.

Where each step leaves the part rho of an error, and the last one changed an eigenvalue by d, then
rho d / (1 - rho) is left; rho is measured by the changes of the last two steps. A step that did not
shrink the change bounds nothing.

Eigenvalues that nearly coalesce move like roots of what their polynomial does. Of m of them, with
p(z) = prod_k (z - a_k) before the last step, a new value z is within abs(p(z))^(1/m) of a root.
"""

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.eigenvalue_matching import connected

_NEAR = 2.0
"""Distance, in changes of both, within which eigenvalues are bounded together."""


def bounds_by_changes(new: Complexes, before: Complexes, earlier: Complexes) -> Floats:
    """Bounds on the errors of eigenvalues of a real problem after steps, shape (n,).

    Parameters
    ----------
    new, before, earlier
        Eigenvalues after the last step, before it, and before the one before, shape (n,); without
        damping kappa = -lambda^2, with damping lambda.

    Returns
    -------
    Floats
        Infinite where the last step changed no less than the one before.
    """
    n = len(new)
    new, before, earlier = (np.append(each, each.conj()) for each in (new, before, earlier))
    changes, first = np.abs(new - before), np.abs(before - earlier)
    apart = np.abs(new[:, None] - before)
    linked = np.abs(new[:, None] - new) <= _NEAR * (changes[:, None] + changes)
    for members in connected(linked):
        roots = np.prod(apart[np.ix_(members, members)] ** (1 / len(members)), axis=1)
        changes[members] = np.maximum(changes[members], roots)
        first[members] = first[members].max()
    rates = np.divide(changes, first, out=np.zeros_like(changes), where=first > 0)
    with np.errstate(divide="ignore"):
        factors = np.where(rates < 1, np.maximum(1.0, rates / (1 - rates)), np.inf)
    return (changes * factors)[:n]
