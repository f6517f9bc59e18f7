"""ARPACK and SuperLU, through scipy."""

from scipy.sparse import csc_array
from scipy.sparse.linalg import eigs

from cea.matrices import local_part
from comparisons.bench.solve.methods.method import Answer
from comparisons.bench.solve.methods.problem import Problem


def solve(problem: Problem) -> Answer:
    """As many eigenvalues as are wanted, those nearest to the shift."""
    K, M = (csc_array(local_part(m)) for m in (problem.unsymmetric(), problem.mass))
    kappa, vectors = eigs(K, problem.count, M=M, sigma=problem.shift)
    return Answer(kappa, vectors, f"{len(kappa)} nearest to the shift")
