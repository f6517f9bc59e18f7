"""Grids of parameters, and rational functions from those with weights."""

import numpy as np

from cea.arrays import Floats


def grid_points(parameters: tuple[Floats, ...]) -> Floats:
    """Points of a tensor grid in C order, shape (n, number of parameters)."""
    return np.stack(np.meshgrid(*parameters, indexing="ij"), axis=-1).reshape(-1, len(parameters))


def outer_products(a: Floats, b: Floats) -> Floats:
    """Products of all columns of a with all of b, row by row, (n, columns of a and b)."""
    return (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)


def projected(homogeneous: Floats) -> tuple[Floats, Floats]:
    """Positions and derivatives from those of w x and w: (w x)' = w' x + w x'."""
    weight = homogeneous[:, 0, -1]
    x = homogeneous[:, 0, :-1] / weight[:, None]
    turned = homogeneous[:, 1:, :-1] - homogeneous[:, 1:, -1:] * x[:, None]
    return x, (turned / weight[:, None, None]).swapaxes(1, 2)
