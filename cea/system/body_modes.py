"""Elastic modes of a body alone, held by its supports and springs."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.blocks import all_inner, image_of
from cea.eigen.driver import solve_modes
from cea.eigen.krylov_schur import KrylovOptions, nearest
from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.shifted import count_below
from cea.errors import ConvergenceError, InputError
from cea.matrices import destroy

_RIGID = 10.0
"""Frequency relative to its uncertainty up to which a motion is rigid, or lost."""
_RIGID_MOTIONS = 6
"""Most rigid motions of a body in one piece."""
_BELOW = 1e-9
"""Square of a frequency that no elastic mode need be below, relative to :func:`_largest_ratio`."""
_BEYOND = 1e-6
"""What is searched beyond the last mode asked for, relative to its frequency."""


@dataclass(frozen=True)
class ElasticModes:
    """Modes of a body by rising frequency, without rigid motions.

    Parameters
    ----------
    frequencies, uncertainties
        Frequencies and what they may be off by (Hz), shape (n,).
    vectors
        Modes phi with phi^T M phi = 1, the rows of this rank, shape (n_local, n).
    """

    frequencies: Floats
    uncertainties: Floats
    vectors: Floats


def elastic_modes(body: Body, end: float | None, *, wanted: int, most: int) -> ElasticModes:
    """Every elastic mode of a body up to a frequency, and perhaps some beyond.

    Parameters
    ----------
    body
        The body.
    end
        The frequency (Hz); None takes as many modes as are wanted, and the next one.
    wanted
        How many these are.
    most
        Number of modes, rigid ones included, beyond which it is refused.

    Raises
    ------
    InputError
        When there are more.
    ConvergenceError
        When modes are not found, or are lost to rounding.
    """
    pencil = Pencil.of(body.stiffness(), body.mass())
    matrices = pencil.at()
    try:
        least = _BELOW * _largest_ratio(matrices)
        if end is None:
            end = _end_of_lowest(matrices, least, wanted)
        end = _window(matrices, least, (1 + _BEYOND) * end, most)
    finally:
        release(matrices)
    modes = solve_modes(pencil, end)
    uncertainties = modes.growth_uncertainties / (2 * np.pi)
    elastic = modes.frequencies > _RIGID * uncertainties
    lost = int((~elastic & (modes.frequencies > np.sqrt(least) / (2 * np.pi))).sum())
    if lost:
        raise ConvergenceError(f"{lost} of {len(modes)} modes are lost to rounding", best=modes)
    frequencies, vectors = _rayleigh_ritz(body, modes.vectors.real)
    return ElasticModes(frequencies[elastic], uncertainties[elastic], vectors[:, elastic])


def _end_of_lowest(matrices: Matrices, least: float, wanted: int) -> float:
    """A frequency (Hz) up to which there are so many elastic modes, and one more if there is one.

    Eigenvalues that are found are some of those that there are: there may be more below the last
    one, not less.
    """
    count = min(wanted + 1 + _RIGID_MOTIONS, matrices.size)
    found, op = nearest(matrices, -least, count, KrylovOptions())
    op.free()
    return float(np.sqrt(np.sort(found.eigenvalues.real)[count - 1])) / (2 * np.pi)


def _window(matrices: Matrices, least: float, end: float, most: int) -> float:
    """A window (Hz) of the modes up to an end: neither far beyond all of them nor far below.

    Where it ended far beyond, they would be rounding beside its shift; rigid motions alone would be
    rounding beside each other.
    """
    end = max(end, float(np.sqrt(least)) / (2 * np.pi))
    count = count_below(matrices, (2 * np.pi * end) ** 2)
    if count > most:
        raise InputError("modes", f"{count} up to {end:g} Hz", f"at most {most}")
    if count < matrices.size:
        return end
    highest = float(np.sqrt(least / _BELOW)) / (2 * np.pi)
    while highest < end and count_below(matrices, (2 * np.pi * highest) ** 2) < count:
        highest *= 2
    return min(highest, end)


def _largest_ratio(matrices: Matrices) -> float:
    """Largest ratio of diagonal entries of K and M (1/s^2), of the size of the largest kappa."""
    stiffness, mass = matrices.stiffness.getDiagonal(), matrices.mass.getDiagonal()
    stiffness.pointwiseDivide(stiffness, mass)
    largest = float(stiffness.max()[1])
    destroy(stiffness, mass)
    return largest


def _rayleigh_ritz(body: Body, vectors: Floats) -> tuple[Floats, Floats]:
    """Frequencies (Hz) and modes, by rising frequency, in the space that some modes span.

    Of modes far from the shift they were searched about the space is known far better than each is.
    """
    mass, stiffness = body.mass(), body.stiffness()
    gram, form = (
        all_inner(vectors, image_of(each, vectors), mass.comm) for each in (mass, stiffness)
    )
    kappa, turn = eigh(form, gram)
    return np.sqrt(np.maximum(kappa, 0.0)) / (2 * np.pi), vectors @ turn
