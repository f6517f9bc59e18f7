"""Approximate eigenvalues with their vectors, and which of several stand for which."""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Complexes, Ints
from cea.eigen.eigenvalue_matching import DEGENERATE, assign


@dataclass(frozen=True)
class Approximation:
    """Approximate eigenvalues with right and left vectors.

    Parameters
    ----------
    eigenvalues
        lambda (1/s), shape (n,).
    right, left
        Vectors x and y, y^H (lambda^2 M + lambda D + K) = 0: the rows of this rank, (n_local, n).
    """

    eigenvalues: Complexes
    right: Complexes
    left: Complexes


def one_of_each_pair(eigenvalues: Complexes) -> Ints:
    """Modes without those that decay as others, conjugate in lambda^2, grow."""
    decaying = np.flatnonzero((eigenvalues.real < 0) & (eigenvalues.imag > 0))
    growing = eigenvalues[(eigenvalues.real > 0) & (eigenvalues.imag > 0)]
    apart = np.abs(eigenvalues[decaying][:, None] + growing.conj())
    apart /= np.abs(eigenvalues[decaying][:, None])
    mirrored = decaying[assign(apart, DEGENERATE)[0]]
    return np.setdiff1d(np.arange(len(eigenvalues)), mirrored)


def growing(kappa: Complexes) -> Complexes:
    """Lambda of -lambda^2 with Im lambda >= 0; of real ones below zero, the one that grows."""
    values = np.sqrt(-np.asarray(kappa, dtype=complex))
    values = np.where(values.imag < 0, -values, values) + 0j
    return np.where(values.imag == 0, np.abs(values.real), values)


def matched(wanted: Complexes, found: Complexes) -> Ints:
    """Number of the eigenvalue that belongs to each wanted one, of least total distance."""
    return assign(np.abs(wanted[:, None] - found))[1]
