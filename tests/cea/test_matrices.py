"""Products and sums of PETSc matrices."""

import numpy as np
import pytest
from petsc4py import PETSc

from cea.eigen.blocks import times


@pytest.mark.parametrize("order", ["F", "C"])
def test_products_with_many_columns_are_those_column_by_column(order, monkeypatch):
    monkeypatch.setattr("cea.eigen.blocks._NUMBERS", 1)  # 8 columns at a time
    rng = np.random.default_rng(4)
    entries = rng.standard_normal((30, 30)) * (rng.random((30, 30)) < 0.3)
    matrix = PETSc.Mat().createDense((30, 30), array=entries.T.ravel()).convert("aij")
    columns = np.array(rng.standard_normal((30, 19)), order=order)
    before = columns.copy()
    image = times(matrix, columns)
    assert image.flags.f_contiguous
    assert image == pytest.approx(entries @ columns, abs=1e-13)
    assert np.array_equal(columns, before)
    assert np.array_equal(times(matrix, columns[:, 8:9])[:, 0], image[:, 8])
