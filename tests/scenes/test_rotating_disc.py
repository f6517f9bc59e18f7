"""A free disc that rotates, in space: its waves pass by with their number times the rate."""

from functools import cache

import numpy as np
import pytest

from scenes import run_modes
from scenes.spec.reading import read_scene

RATE, THICKNESS = 0.004, 0.1
SPOKES = 48
"""Points round the rim; waves are told apart up to half of them."""


def disc(backend, around, **rotation):
    """A free flat ring with round numbers."""
    part = {
        "backend": backend,
        "geometry": {
            "shape": "annulus",
            "inner_radius": 0.5,
            "outer_radius": 1.0,
            "bottom": 0.0,
            "top": THICKNESS,
        },
        "material": {"E": 1.0, "nu": 0.3, "rho": 1.0},
        "mesh": {
            "fe": {"cell": "hexahedron", "degree": 2, "elements": [1, around, 1]},
            "iga": {"degree": [3, 3, 2], "elements": [1, around, 1]},
        },
    }
    if rotation:
        part["rotation"] = {"rate": RATE, **rotation}
    data = {
        "name": "free disc",
        "bodies": {"disc": part},
        "analysis": {"kind": "cea", "max_frequency": 0.06},
    }
    return run_modes(read_scene(data))


def waves(result, modes):
    """Number of waves round the rim of each mode, counted in components along r, theta and z."""
    rim = result.bodies["disc"].surfaces["outer"]
    theta = 2 * np.pi * np.arange(SPOKES) / SPOKES
    around = np.stack([np.cos(theta), np.sin(theta), np.zeros(SPOKES)], axis=1)
    x = around + np.array([0.0, 0.0, 0.3 * THICKNESS])
    shapes = result.mode_shapes("disc.outer", rim.locate(x, around, 0.1).at, modes)
    axes = np.stack([around, np.cross([0.0, 0.0, 1.0], around), np.tile([0, 0, 1.0], (SPOKES, 1))])
    components = np.einsum("cnd,ndm->cnm", axes, shapes)
    power = (np.abs(np.fft.fft(components, axis=1)) ** 2).sum(axis=0)
    return np.argmax(power[: SPOKES // 2] + np.roll(power[::-1], 1, axis=0)[: SPOKES // 2], axis=0)


@cache
def errors(backend, around):
    """Distance from lambda_0 +- i m Omega of each wave, relative to m Omega."""
    rest = disc(backend, around)
    elastic = np.flatnonzero(rest.frequencies > 0.01)
    numbers = waves(rest, elastic)
    omega = rest.eigenvalues[elastic].imag
    turning = disc(backend, around, coriolis=False, convective_stiffness=True).eigenvalues
    found = {}
    for m, at in zip(numbers, omega, strict=True):
        if m:
            apart = [np.abs(turning - 1j * (at + s * m * RATE)).min() for s in (-1, 1)]
            found[int(m)] = max(found.get(int(m), 0.0), max(apart) / (m * RATE))
    return found


@pytest.mark.convergence
@pytest.mark.parametrize("backend", ["fe", pytest.param("iga", marks=pytest.mark.slow)])
def test_waves_pass_by_with_their_number_times_the_rate(backend):
    coarse, fine = errors(backend, 8), errors(backend, 16)
    assert {2, 3} <= set(fine)
    assert max(fine[m] for m in (2, 3)) < 5e-3
    assert coarse[2] / fine[2] > 12
