"""Eigenvalues and bounds that must not depend on the number of ranks."""

import numpy as np
from blocks import assemble, coarse, two_blocks
from random_pencils import random_graded

from cea.eigen.coefficients import Coefficient
from cea.eigen.driver import EigenSolver, solve_modes
from cea.eigen.pencil import Pencil, Term
from cea.matrices import distributed, local_part


def damped(pencil, alpha, beta, turning=0.0):
    """A pencil with alpha M + beta S as damping, and a skew matrix made of the mass as rotation."""
    terms = list(pencil.terms)
    for term in pencil.terms:
        rate = {"mass": alpha, "stiffness": beta}[term.role]
        if rate and term.symmetric:
            c = term.coefficient
            c = Coefficient(c.powers, rate * c.factor)
            terms.append(Term("damping", term.matrix, c))
    if turning:
        mass = next(t for t in pencil.terms if t.role == "mass").matrix
        terms.append(Term("damping", _skew(mass), Coefficient({}, factor=turning), symmetric=False))
    return Pencil(terms, pencil.parameters.values(), pencil.forces)


def _skew(matrix):
    """A M - M A with the diagonal A of a matrix M over its mean: the same on any ranks."""
    part = local_part(matrix).tocoo()
    rows = part.row + matrix.getOwnershipRange()[0]
    own = matrix.getDiagonal().array
    diagonal = np.concatenate(matrix.comm.tompi4py().allgather(own))
    diagonal /= diagonal.sum() / np.count_nonzero(diagonal)
    part.data *= diagonal[rows] - diagonal[part.col]
    return distributed(part.tocsr(), matrix.getSizes()[1], matrix.comm)


def damped_blocks():
    """Modes of two damped, rotating blocks in contact."""
    found = {}
    for form in ("penalty", "saddle"):
        data = coarse(two_blocks("iga", {"method": "gpts", "points": 3}, mu=0.4, held=True))
        data["contacts"]["interface"] |= {"form": form}
        pencil = damped(assemble(data).pencil(), 0.05, 0.01, turning=0.1)
        modes = solve_modes(pencil, 1.0, left=True)
        found |= {
            f"re {form}": modes.growth_rates.tolist(),
            f"im {form}": modes.eigenvalues.imag.tolist(),
            f"slope {form}": np.abs(modes.sensitivity("contacts.interface.mu")).tolist(),
        }
        with EigenSolver(pencil) as driver:
            near = driver.nearest(-((0.2 + 4j) ** 2), 3).eigenvalues
        found |= {f"near {form}": [*near.real, *near.imag]}
    return found | {"re": found["re penalty"]}


def graded(seed, damped):
    """Eigenvalues and verdicts of a graded pencil, with left vectors."""
    problem = random_graded(seed, 20, damped=damped)
    modes = solve_modes(problem.pencil(), problem.max_frequency, left=True)
    return {
        "re": modes.growth_rates.tolist(),
        "im": modes.eigenvalues.imag.tolist(),
        "verdicts": modes.verdicts(),
    }
