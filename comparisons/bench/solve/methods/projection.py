"""Projection on real modes: those without friction, of the bodies in contact.

What most programs of industry do: the pencil with friction is projected on the lowest modes of its
symmetric part and solved densely.
"""

from typing import Any

import numpy as np
from scipy.linalg import eig

from cea.arrays import Floats
from cea.matrices import dense, destroy
from comparisons.bench.solve.methods.method import Answer
from comparisons.bench.solve.methods.problem import Problem
from comparisons.bench.solve.methods.slepc_krylov_schur import symmetric_modes


def solve(problem: Problem, count: int) -> Answer:
    """Every eigenvalue of the pencil projected on so many modes."""
    modes = symmetric_modes(problem, count)
    basis = np.asfortranarray(modes.vectors[:, :count].real)  # some more may have converged
    K, M = (_projected(m, basis) for m in (problem.unsymmetric(), problem.mass))
    kappa, vectors = eig(K, M)
    return Answer(kappa, basis @ vectors, f"on {basis.shape[1]} real modes")


def _projected(matrix: Any, basis: Floats) -> Floats:
    """Products of a basis, the rows of this rank, with its image."""
    right = dense(basis, matrix.getSizes()[0], matrix.comm)
    image = matrix.matMult(right)
    product: Floats = matrix.comm.tompi4py().allreduce(basis.T @ image.getDenseArray())
    destroy(right, image)
    return product
