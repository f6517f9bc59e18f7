"""Motions of free bodies given as functions of position, and what forces they meet."""

import numpy as np

from cea.petsc import PETSc


def unknowns(system, motions):
    """Unknowns of free bodies that move as given: displacement functions of position by body."""
    x = system.vector()
    for name, motion in motions.items():
        x.array[system.pieces[name].rows] = motion(control_points(system.bodies[name])).ravel()
    return x


def control_points(body):
    """Coefficients that reproduce x, from the body's own cells."""
    cells = body.space.volume_cells()
    return np.linalg.lstsq(cells.values.toarray(), cells.points, rcond=None)[0]


def resultant(system, force, body):
    """Sum of nodal forces of a free body, by component, and the largest of them."""
    nodal = system.displacement(force, body).reshape(-1, 3)
    return nodal.sum(axis=0), np.abs(nodal).sum()


def asymmetry(matrix):
    """Norm of a PETSc matrix less its transpose: zero on any number of ranks."""
    difference = matrix.transpose(PETSc.Mat())
    difference.axpy(-1.0, matrix, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    return difference.norm()


def mode_displacement(result, body, mode):
    """Displacement of the scalar dofs of a body in a mode, one vector at a time, (n, dim)."""
    parts = [result.system.displacement(x, body) for x in result.modes.vector(mode)]
    return (parts[0] + 1j * parts[1]).reshape(-1, result.bodies[body].dim)


def rigid_motions(x):
    """Translations, then rotations, of points x: one in each column, (n * dim, motions)."""
    dim = x.shape[1]
    spins = [[0, 1]] if dim == 2 else [[0, 1], [0, 2], [1, 2]]
    turns = []
    for i, j in spins:
        turn = np.zeros_like(x)
        turn[:, i], turn[:, j] = -x[:, j], x[:, i]
        turns.append(turn.ravel())
    return np.column_stack([np.tile(e, len(x)) for e in np.eye(dim)] + turns)
