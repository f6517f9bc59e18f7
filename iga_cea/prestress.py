"""Stiffness that the stresses of a displacement make in joined patches (:class:`cea.body.Body`).

One scalar matrix for all components,

    g_ab = int sigma_ij dN_a/dx_i dN_b/dx_j,    sigma = lambda tr(eps) 1 + 2 mu eps.
"""

from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.material import IsotropicMaterial
from iga_cea.assembly import distributed_matrix
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.quadrature import batches


def geometric_stiffness(
    multipatch: Multipatch,
    pattern: Pattern,
    material: IsotropicMaterial,
    displacement: Floats,
    comm: Any,
) -> Any:
    """The matrix of all dofs.

    Parameters
    ----------
    multipatch
        The joined patches.
    pattern
        Pattern of this rank.
    material
        The material.
    displacement
        Displacement of all scalar dofs (m), shape (num_scalar_dofs, dim).
    comm
        MPI communicator.

    Returns
    -------
    PETSc.Mat
        AIJ matrix of block size dim (N/m), exactly symmetric in serial.
    """
    data = np.zeros(len(pattern.columns))
    local = displacement[pattern.dofs]
    for batch in batches(multipatch, pattern, comm.rank, components=1):
        slope = local[batch.rows].swapaxes(1, 2)[:, None] @ batch.gradients
        stress = material.stress(slope) * batch.measure[..., None, None]
        pulled = batch.gradients @ stress
        g = np.einsum("epai,epbi->eab", pulled, batch.gradients, optimize=True)
        g = 0.5 * (g + g.swapaxes(1, 2))
        for a, row, place in batch.places:
            data[pattern.starts[row][:, None] + place] += g[:, a]
    return distributed_matrix(multipatch, pattern, pattern.expanded(data, multipatch.dim), comm)
