"""Strain energies of the bodies of a system in its modes."""

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.blocks import columns_inner, times
from cea.system.coupled import CoupledSystem


def strain_energies(system: CoupledSystem, vectors: Complexes) -> dict[str, Floats]:
    """Strain energy of each body in each mode, x_b^H K_b x_b (J, twice); collective.

    Springs of supports and contacts hold the rest of x^H K x.

    Parameters
    ----------
    system
        The system.
    vectors
        Eigenvectors x, the rows of this rank, shape (n_local, n).

    Returns
    -------
    dict
        By body, shape (n,).
    """
    first = system.template.getOwnershipRange()[0]
    energies = {}
    for name, body in system.bodies.items():
        own = np.asarray(vectors[system.index_sets[name].getIndices() - first])
        product = times(body.stiffness(), own)
        energies[name] = columns_inner(own, product, system.template.comm).real
    return energies
