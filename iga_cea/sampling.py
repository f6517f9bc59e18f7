"""Samples of the whole of a body of patches."""

import numpy as np
from scipy.sparse import csr_array, vstack

from cea.errors import InputError
from cea.volume import VolumeSample
from iga_cea.multipatch import Multipatch
from iga_cea.patch import outward, subdivided, tensor_cells


def sample_volume(multipatch: Multipatch, subdivisions: int) -> VolumeSample:
    """Sample of all patches, each knot span divided so many times a direction.

    Points on joints of patches appear once for each patch.

    Raises
    ------
    InputError
        When subdivisions is less than 1.
    """
    if subdivisions < 1:
        raise InputError("subdivisions", subdivisions, "at least 1")
    cells, values, count = [], [], 0
    for patch, dofs in zip(multipatch.patches, multipatch.dofs, strict=True):
        parameters = [subdivided(breaks, subdivisions) for breaks in patch.breaks]
        basis = patch.basis_on_grid(parameters)
        columns = dofs.ravel()[basis.indices]
        shape = (basis.shape[0], multipatch.num_scalar_dofs)
        values.append(csr_array((basis.data, columns, basis.indptr), shape=shape))
        grid = tensor_cells([len(x) for x in parameters])
        cells.append(count + outward(grid, values[-1] @ multipatch.control_points))
        count += basis.shape[0]
    every = csr_array(vstack(values, format="csr"))
    return VolumeSample(every @ multipatch.control_points, np.concatenate(cells), every)
