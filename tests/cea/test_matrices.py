"""Products and sums of PETSc matrices."""

import numpy as np
import pytest
from petsc4py import PETSc
from scipy.sparse import csr_array

from cea.eigen.blocks import image_of
from cea.matrices import absolute, symmetrised


@pytest.mark.parametrize("mirrored", [True, False])
def test_entries_whose_mirror_image_is_not_stored_are_symmetrised(mirrored):
    entries = np.array([[2.0, 1.0, 0.0], [3.0 if mirrored else 0.0, 4.0, 0.0], [0.0, 5.0, 6.0]])
    stored = csr_array(entries)
    matrix = PETSc.Mat().createAIJ(
        stored.shape,
        csr=(
            stored.indptr.astype(PETSc.IntType),
            stored.indices.astype(PETSc.IntType),
            stored.data,
        ),
    )
    found = symmetrised(matrix).convert("dense").getDenseArray()
    assert np.array_equal(found, 0.5 * (entries + entries.T))


def test_absolute_values_leave_the_matrix_as_it_is():
    entries = np.array([[2.0, -1.0, 0.0], [0.0, -4.0, 5.0]])
    matrix = PETSc.Mat().createDense(entries.shape, array=entries.T.ravel()).convert("aij")
    found = absolute(matrix)
    x, y = found.createVecs()
    x.array[:] = [1.0, -10.0, 100.0]
    found.mult(x, y)
    assert y.array.tolist() == [-8.0, 460.0]
    assert np.array_equal(matrix.convert("dense").getDenseArray(), entries)
    assert found.getSizes() == matrix.getSizes()


@pytest.mark.parametrize("order", ["F", "C"])
def test_products_with_many_columns_are_those_column_by_column(order, monkeypatch):
    monkeypatch.setattr("cea.eigen.blocks._NUMBERS", 1)  # 8 columns at a time
    rng = np.random.default_rng(4)
    entries = rng.standard_normal((30, 30)) * (rng.random((30, 30)) < 0.3)
    matrix = PETSc.Mat().createDense((30, 30), array=entries.T.ravel()).convert("aij")
    columns = np.array(rng.standard_normal((30, 19)), order=order)
    before = columns.copy()
    image = image_of(matrix, columns)
    assert image.flags.f_contiguous
    assert image == pytest.approx(entries @ columns, abs=1e-13)
    assert np.array_equal(columns, before)
    assert np.array_equal(image_of(matrix, columns[:, 8:9])[:, 0], image[:, 8])
