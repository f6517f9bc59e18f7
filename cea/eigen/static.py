"""Static equilibrium K x = load by one factorisation, rejected if rounding dominates."""

from dataclasses import dataclass

import numpy as np

from cea.arrays import Floats
from cea.eigen.pencil import Matrices, Pencil, Sizes, release
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError, InputError
from cea.petsc import Vec
from cea.timing import StageTimer

_SINGULAR = "the stiffness is singular: the bodies are not held by supports and contacts"
_LOST = 0.1
"""Rounding error relative to the displacement from which on a solution is rejected."""
_PROBES = 4
"""Number of random perturbations of the size of rounding."""


@dataclass(frozen=True)
class Equilibrium:
    """Free displacements (m), contact forces that are unknowns (N), and the relative error."""

    displacement: Vec
    forces: Floats
    uncertainty: float


def solve_static(pencil: Pencil, load: Vec | None, timer: StageTimer | None = None) -> Equilibrium:
    """Return the equilibrium under a load (N), a PETSc vector, at the default parameters.

    InputError when there is no load, ConvergenceError when the stiffness is singular, or so nearly
    singular that rounding dominates the displacements, which are then attached.
    """
    if load is None:
        raise InputError("load", None, "a load vector: the system was coupled without forces")
    timer = timer or StageTimer()
    with timer("assembly"):
        matrices = pencil.at()
    x = load.duplicate()
    with timer("factorisation"):
        try:
            factors = Shifted(matrices)
        except ConvergenceError as error:
            raise ConvergenceError(f"{_SINGULAR} ({error})") from error
        displacement, forces = factors.solve_with_forces(
            np.array(load.array_r, dtype=np.float64)[:, None]
        )
        x.array[:] = displacement[:, 0]
        uncertainty = rounding_uncertainty(matrices, factors, displacement, forces)
        factors.free()
    release(matrices)
    if not uncertainty < _LOST:
        raise ConvergenceError(
            f"{_SINGULAR}; rounding errors reach {uncertainty:.1e} of the displacements",
            best=x,
        )
    return Equilibrium(x, forces[:, 0], uncertainty)


def rounding_uncertainty(matrices: Matrices, factors: Shifted, x: Floats, f: Floats) -> float:
    """Return the effect of random rounding of K on displacements, relative to the largest.

    ``factors`` are those at kappa = 0; displacements x and contact forces f have one column each.
    """
    comm = matrices.stiffness.comm.tompi4py()
    sizes = Sizes(matrices)
    forces = sizes.forces(x, f)
    sizes.free()
    rounding = np.finfo(float).eps * forces
    signs = np.random.default_rng(comm.rank).choice([-1.0, 1.0], size=(len(x), _PROBES))
    moved = factors.solve_block(rounding * signs)
    largest = np.array([np.abs(moved).max(initial=0.0), np.abs(x).max(initial=0.0)])
    error, size = np.array(comm.allgather(largest)).max(axis=0)
    return float(error / size) if size else 0.0
