"""Knots and weights that make no patch are refused."""

from types import SimpleNamespace

import numpy as np
import pytest

from cea.errors import InputError
from iga_cea.patch import check_geometry


def plane(knots, weight=1.0):
    """A square of 4 x 4 quadratic functions."""
    x = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 2, indexing="ij"), axis=-1)
    weights = np.ones((4, 4))
    weights[0, 0] = weight
    ends = (np.array([0.0, 1.0]),) * 2
    return SimpleNamespace(
        degrees=(2, 2),
        knots=(np.asarray(knots, dtype=float),) * 2,
        control_points=x,
        weights=weights,
        breaks=ends,
    )


@pytest.mark.parametrize("knots", [[0, 0, 0.5, 1, 1], [0, 0, 0, 0.6, 1, 1, 0.9], [0] * 3 + [1] * 4])
def test_knots_must_rise_and_join(knots):
    with pytest.raises(InputError, match=r"patch.knots\[0\] = .*rising knots"):
        check_geometry(plane(knots), "patch")


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan])
def test_weights_must_be_positive(weight):
    with pytest.raises(InputError, match=r"patch.weights.*positive"):
        check_geometry(plane([0, 0, 0, 0.5, 1, 1, 1], weight), "patch")
