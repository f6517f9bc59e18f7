"""Stiffness that the stresses of a displacement make in joined patches (:class:`cea.body.Body`).

One scalar matrix for all components,

    g_ab = int sigma_ij dN_a/dx_i dN_b/dx_j,    sigma = lambda tr(eps) 1 + 2 mu eps.
"""

from itertools import product
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.material import IsotropicMaterial
from iga_cea.entries import entries
from iga_cea.metric import Metric
from iga_cea.multipatch import Multipatch
from iga_cea.pattern import Pattern
from iga_cea.separation import Coefficients
from iga_cea.storage import Kept, component_matrix
from iga_cea.sum_factorisation import Form


def geometric_stiffness(
    multipatch: Multipatch,
    pattern: Pattern,
    material: IsotropicMaterial,
    displacement: Floats,
    comm: Any,
    kept: Kept | None = None,
) -> Any:
    """The matrix.

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
    kept
        Unknowns that stay; None of all.

    Returns
    -------
    PETSc.Mat
        AIJ matrix (N/m), exactly symmetric; of block size dim where all unknowns stay.
    """

    def coefficients(metric: Metric) -> Coefficients:
        slope = np.moveaxis(metric.field_gradient, (0, 1), (-2, -1))
        stress = np.moveaxis(material.stress(slope), (-2, -1), (0, 1)) * metric.measure
        pulled = {k: np.einsum("ab...,b...->a...", stress, g) for k, g in metric.gradients.items()}
        return {
            (k, m): np.sum(metric.gradients[k] * pulled[m], axis=0)[None]
            for k, m in product(pulled, repeat=2)
        }

    form = Form(1, coefficients, displacement)
    data = entries(multipatch, pattern, form, comm)
    return component_matrix(pattern, data, multipatch.dim, kept, comm)
