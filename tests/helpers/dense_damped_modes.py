"""Modes of damped scenes beside the dense eigenvalues of their matrices."""

import numpy as np

from comparisons.stability.dense import dense_eigenvalues
from scenes import run_modes
from scenes.spec.reading import read_scene


def in_window(values, window):
    """Eigenvalues of the upper half that a window holds."""
    inside = (values.imag >= 0) & (values.imag <= 2 * np.pi * window.max_frequency)
    return np.sort_complex(values[inside & (values.real >= window.min_growth)])


def assert_modes_are_dense(data):
    """Every mode of a scene is an eigenvalue of its dense matrices, and all of the window are."""
    modes = run_modes(read_scene(data)).modes
    expected = in_window(dense_eigenvalues(data), modes.window)
    assert len(expected) > 5
    np.testing.assert_allclose(np.sort_complex(modes.eigenvalues), expected, rtol=1e-9, atol=1e-9)
