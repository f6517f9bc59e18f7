"""A graded pencil on any number of ranks: its modes, and what they are known to."""

import numpy as np
from random_graded import random_graded, random_graded_damped
from scipy.sparse import csr_array

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil, Term
from cea.matrices import distributed
from cea.petsc import MPI
from cea.ranks import local_rows


def graded_numbers(seed, damped):
    """Eigenvalues, verdicts, and the residual of the eigenvectors in the unknowns as given."""
    problem = (random_graded_damped if damped else random_graded)(seed, 20)
    plain = problem.plain
    terms = []
    for role in ("mass", "stiffness", "damping"):
        matrix = getattr(plain, role)
        if matrix is not None:
            whole = problem.scaled(matrix)
            equal = np.where(whole == whole.T, whole, 0.0)
            terms.append(Term(role, _on_ranks(equal)))
            if (whole != equal).any():
                terms.append(Term(role, _on_ranks(whole - equal), symmetric=False))
    modes = solve_modes(Pencil(terms), problem.max_frequency, left=True)
    return {
        "re": modes.eigenvalues.real.tolist(),
        "im": modes.eigenvalues.imag.tolist(),
        "verdicts": modes.verdicts(),
        "complete": modes.window.complete,
    }


def _on_ranks(matrix):
    first, last = local_rows(len(matrix), MPI.COMM_WORLD)
    return distributed(csr_array(matrix[first:last]), (last - first, len(matrix)), MPI.COMM_WORLD)
