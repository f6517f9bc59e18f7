"""Elastic modes of an uncoupled body with modal damping, and their damping."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import eigh

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.block_products import all_inner, times
from cea.eigen.driver import EigenSolver
from cea.eigen.pencil import Pencil
from cea.eigen.shifted import count_below
from cea.errors import ConvergenceError, InputError
from cea.matrices import diagonal_of
from cea.motion import ModalDamping
from cea.petsc import MPI

_MOST = 2000  # largest number of damped modes of a body
_RIGID = 10.0  # ratio of frequency and uncertainty up to which a mode is rigid, or lost to rounding
_BELOW = 1e-9
"""Squared frequency, relative to the largest, below which no elastic mode is expected."""
_BEYOND = 1e-6  # margin of the search above the highest frequency, relative


@dataclass(frozen=True)
class DampedModes:
    """Damped modes of a body: C = sum_j 2 zeta_j omega_j (M phi_j) (M phi_j)^T."""

    # phi with phi^T M phi = 1, and M phi, the rows of this rank, shape (n_local, n)
    vectors: Floats
    images: Floats
    weights: Floats  # 2 zeta omega (1/s) at a parameter of 1, shape (n,)


def damped_modes(path: str, body: Body, damping: ModalDamping) -> DampedModes:
    """Return the modes with modal damping; rigid body modes are excluded."""
    try:
        frequencies, vectors = _elastic_modes(path, body, damping.end)
    except ConvergenceError as error:
        raise ConvergenceError(f"modal damping of {path}: {error}") from error
    factors = damping.factors_at(frequencies)
    damped = factors > 0
    vectors, weights = vectors[:, damped], (4 * np.pi * factors * frequencies)[damped]
    return DampedModes(vectors, times(body.mass(), vectors), weights)


def _elastic_modes(path: str, body: Body, end: float) -> tuple[Floats, Floats]:
    """Return all elastic modes of a body up to a frequency (Hz), and perhaps some beyond.

    Increasing frequencies (Hz), shape (n,), and vectors phi with phi^T M phi = 1, the rows of
    this rank.
    """
    with EigenSolver(Pencil.of(body.stiffness(), body.mass())) as solver:
        matrices = solver.matrices()
        # estimate of the largest kappa (1/s^2)
        ratios = diagonal_of(matrices.stiffness) / diagonal_of(matrices.mass)
        largest = float(body.comm.allreduce(ratios.max(initial=0.0), MPI.MAX))
        least, highest = (float(np.sqrt(part * largest)) / (2 * np.pi) for part in (_BELOW, 1.0))
        end = max((1 + _BEYOND) * end, least)
        modes_below = count_below(matrices, (2 * np.pi * end) ** 2)
        if modes_below > _MOST:
            allowed = f"at most {_MOST} damped modes; use Rayleigh damping for more"
            raise InputError(f"{path}.damping.modal", f"{modes_below} up to {end:g} Hz", allowed)
        if modes_below == matrices.size:  # reduce the end to one just above all modes
            below = partial(count_below, matrices)
            while highest < end and below((2 * np.pi * highest) ** 2) < matrices.size:
                highest *= 2
            end = min(highest, end)
        modes = solver.solve(end)
    uncertainties = modes.growth_uncertainties / (2 * np.pi)
    elastic = modes.frequencies > _RIGID * uncertainties
    if lost := int((~elastic & (modes.frequencies > least)).sum()):
        raise ConvergenceError(f"{lost} of {len(modes)} modes are lost to rounding", best=modes)
    # Rayleigh-Ritz projection on the computed modes.
    vectors = modes.vectors.real
    form, gram = (
        all_inner(vectors, times(each, vectors), each.comm)
        for each in (body.stiffness(), body.mass())
    )
    kappa, turn = eigh(form, gram)
    frequencies = np.sqrt(np.maximum(kappa, 0.0)) / (2 * np.pi)
    return frequencies[elastic], (vectors @ turn)[:, elastic]
