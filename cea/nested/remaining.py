"""What is left of errors of eigenvalues after steps that converge, by what the last ones changed.

Where a step leaves the part rho of an error, and the last one changed an eigenvalue by d, then
rho d / (1 - rho) is left, which is no more than d while rho <= 1/2. The bound is twice that, times
the condition of the eigenvalue, and what rounding does. It is no theorem, for rho is measured by
the changes of two steps, in which a slow component of the error may hide. So no less is left of the
change before the last than

- rho of any other mode, times the ratio of both distances from the shift where that one is farther:
  a component of another eigenvalue kappa_j shrinks by (kappa - sigma) / (kappa_j - sigma), and by
  its square with damping, where steps are whole ones;
- what damping leaves of components of damping d and stiffness k, abs(lambda) d / k of vectors.

Steps of rho >= 1 bound nothing.

Eigenvalues that nearly coalesce move like roots of what their polynomial does. Of m of them, with
p(z) = prod_k (z - a_k) before the last step, a new value z is within abs(p(z))^(1/m) of a root.
"""

from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import columns_inner, times
from cea.eigen.matching import connected
from cea.eigen.pencil import Matrices
from cea.eigen.residuals import Damping, Sizes
from cea.nested.clusters import NEAR
from cea.nested.ritz import DEPENDENT, Approximation

_SAFETY = 2.0
"""Factor on what is left by the changes of steps."""


def left_of_errors(
    new: Approximation,
    before: tuple[Complexes, Complexes],
    slowest: Floats,
    matrices: Matrices,
    damping: Damping,
    shift: float,
) -> Floats:
    """Bounds on the errors of eigenvalues after steps (1/s), shape (n,); collective.

    Parameters
    ----------
    new
        After the last step.
    before
        Eigenvalues before the last step, and before the last but one.
    slowest
        What damping makes rho of such components, shape (n,).
    matrices, damping
        The pencil.
    shift
        sigma (1/s^2), about which steps shrink errors.

    Returns
    -------
    Floats
        Infinite where the steps do not converge, as far as they show.
    """
    comm, values = matrices.stiffness.comm, new.eigenvalues
    inertia = columns_inner(new.left, times(matrices.mass, new.right), comm)
    drag = columns_inner(new.left, damping.times(new.right), comm)
    slopes = np.maximum(np.abs(2 * values * inertia + drag), np.finfo(float).tiny)
    error = _rounding(new, matrices, damping) + DEPENDENT * (np.abs(values) ** 2 + abs(shift))
    rounding = np.minimum(
        error / slopes, np.sqrt(error / np.maximum(np.abs(inertia), np.finfo(float).tiny))
    )
    conditions = np.maximum(1.0, 2 * np.abs(values) / slopes)
    distances = np.abs(values**2 + shift)
    sequence = (values, *before)
    damped = matrices.quadratic
    left = _by_changes(sequence, distances, slowest, rounding, damped=damped)
    return left * conditions + rounding


def _rounding(new: Approximation, matrices: Matrices, damping: Damping) -> Floats:
    """What rounding the entries of the matrices does to lambda^2 (1/s^2), x^H M x = y^H M y = 1."""
    sizes, comm = Sizes(matrices, damping), matrices.stiffness.comm
    forces = matrices.multipliers
    rows = 0 if forces is None else forces.compliance.getLocalSize()[0]
    none: Any = np.zeros((rows, len(new.eigenvalues)), dtype=complex)
    works = [
        columns_inner(np.abs(part), sizes.forces(part, none, new.eigenvalues), comm)
        for part in (new.right, new.left)
    ]
    sizes.free()
    return np.asarray(np.finfo(float).eps * np.sqrt(works[0] * works[1]))


def _by_changes(
    sequence: tuple[Complexes, Complexes, Complexes],
    distances: Floats,
    slowest: Floats,
    rounding: Floats,
    *,
    damped: bool,
) -> Floats:
    """Bounds by what the last step changed, and the one before, for eigenvalues at distances."""
    new, before, earlier = sequence
    first = np.abs(before - earlier)
    last = _changes(*(_with_twins(values, damped=damped) for values in (new, before)))[: len(new)]
    # Changes that are rounding have no rate.
    rates = np.where(last > rounding, last / np.maximum(first, np.finfo(float).tiny), 0.0)
    converges = np.maximum(rates, slowest) < 1
    others = np.minimum(1.0, distances[:, None] / np.maximum(distances, np.finfo(float).tiny))
    others = np.minimum(rates, 1.0) * others ** (2 if damped else 1)
    others = np.where(converges | (distances[:, None] < distances), others, 0.0).max(axis=1)
    rates, slowest = (np.where(converges, each, 0.0) for each in (rates, slowest))
    left = last * np.maximum(1.0, rates / (1 - rates))
    hidden = first * np.maximum(others, slowest**2 / (1 - slowest))
    return np.where(converges, _SAFETY * np.maximum(left, hidden), np.inf)


def _with_twins(values: Complexes, *, damped: bool) -> Complexes:
    """With the conjugates, which a real problem has too, and without damping -lambda."""
    values = np.append(values, values.conj())
    return values if damped else np.append(values, -values)


def _changes(new: Complexes, before: Complexes) -> Floats:
    """What a step changed; of those that nearly coalesce, by what it changed their polynomial."""
    changes = np.abs(new - before)
    apart = np.abs(new[:, None] - before)
    linked = np.abs(new[:, None] - new) <= NEAR * (changes[:, None] + changes)
    for members in connected(linked):
        roots = np.prod(apart[np.ix_(members, members)] ** (1 / len(members)), axis=1)
        changes[members] = np.maximum(changes[members], roots)
    return np.asarray(changes)
