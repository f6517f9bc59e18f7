"""Momentum that contact forces lose: their resultants on both bodies together."""

from collections.abc import Mapping

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

from cea.arrays import Floats
from cea.body import Body
from cea.petsc import PETSc
from cea.system.coupled import CoupledSystem


def rigid_motions(body: Body) -> Floats:
    """Full displacements of the rigid motions of a body, shape (motions, full dofs).

    Translations along each coordinate, then rotations about the origin. Coefficients that
    reproduce the coordinates are found by least squares from those of its cells.
    """
    comm, dim = body.comm, body.dim
    cells = body.space.volume_cells()
    x = None
    if comm.rank == 0:
        values = csr_array(cells.values)
        x = spsolve((values.T @ values).tocsc(), values.T @ cells.points)
    x = comm.bcast(x)
    spins = [(i, j) for i in range(dim) for j in range(i)]
    motions = np.zeros((dim + len(spins), len(x), dim))
    for i in range(dim):
        motions[i, :, i] = 1
    for motion, (i, j) in zip(motions[dim:], spins, strict=True):
        motion[:, i], motion[:, j] = -x[:, j], x[:, i]
    return motions.reshape(len(motions), -1)


def momentum_defects(system: CoupledSystem, motions: Mapping[str, Floats]) -> dict[str, float]:
    """Resultants of contact forces on both bodies together, relative.

    For a rigid motion r of both bodies, r^T K x is the resultant of the forces K x along it: it
    vanishes for every x where K^T r does. The largest entry of K^T r is related to the largest
    column sum of abs(K) times the largest entry of r.

    Bodies have no supports: their free dofs are the full ones. ``linear`` and ``angular`` are those
    of ``_normal`` and ``_friction`` forces.
    """
    dim = next(iter(system.bodies.values())).dim
    r, y = (system.vector() for _ in range(2))
    defects: dict[str, float] = {}
    for kind, name_of_matrix in (("normal", "K_n"), ("friction", "K_f")):
        every = (getattr(contact, name_of_matrix) for contact in system.contacts)
        matrices = [matrix for matrix in every if matrix is not None]
        scale = sum(matrix.norm(PETSc.NormType.NORM_1) for matrix in matrices)
        for number in range(len(next(iter(motions.values())))):
            for name, motion in motions.items():
                part = r.getSubVector(system.index_sets[name])
                part.array[:] = motion[number, slice(*part.owner_range)]
                r.restoreSubVector(system.index_sets[name], part)
            y.set(0.0)
            for matrix in matrices:
                matrix.multTransposeAdd(r, y, y)
            size = r.norm(PETSc.NormType.NORM_INFINITY)
            defect = y.norm(PETSc.NormType.NORM_INFINITY) / (scale * size)
            key = f"{'linear' if number < dim else 'angular'}_{kind}"
            defects[key] = max(defects.get(key, 0.0), float(defect))
    return defects
