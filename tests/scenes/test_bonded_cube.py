"""A cube on rollers, cut in two and bonded, meshes that do not match: the order of the elements.

A unit cube of which every face moves in its plane alone has the modes

    u = (A sin(l pi x) cos(m pi y) cos(n pi z), B cos sin cos, C cos cos sin),

with kappa = omega^2 = c^2 pi^2 (l^2 + m^2 + n^2): A, B, C along (l, m, n) for waves of pressure,
c^2 = (lambda + 2 mu) / rho, across it for those of shear, c^2 = mu / rho. They are smooth, so that
eigenvalues of elements of degree p err like h^(2 p), whatever the cut.
"""

from itertools import product

import numpy as np
import pytest

from scenes import run_modes
from scenes.spec.reading import read_scene

E, NU, RHO = 1.0, 0.3, 1.0
HIGHEST = 0.65
"""Frequency (Hz) up to which modes are looked at: eight of them."""
FACES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")
CUT = 0.4
UPPER, LOWER = (2, 2, 1), (3, 3, 2)
"""Elements of both halves on the coarsest mesh, 2 against 3 along each edge of the joint."""


def exact():
    """Kappa of the modes up to the highest frequency, rising."""
    mu = E / (2 * (1 + NU))
    pressure = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))
    found = []
    for wave in product(range(4), repeat=3):
        # A component whose own number is zero vanishes; one direction is that of the wave.
        across = np.count_nonzero(wave) - 1
        square = np.pi**2 * np.dot(wave, wave)
        if across >= 0:
            found += [pressure / RHO * square] + [mu / RHO * square] * across
    return np.sort([kappa for kappa in found if kappa < (2 * np.pi * HIGHEST) ** 2])


def half(backend, size, origin, elements, degree, joint):
    """A part of the cube; its other faces are rollers."""
    faces = [name for name in FACES if name != joint]
    return {
        "backend": backend,
        "geometry": {"shape": "box", "size": size, "origin": origin},
        "material": {"E": E, "nu": NU, "rho": RHO},
        "supports": [{"surface": name, "components": [name[0]]} for name in faces],
        "mesh": {
            "fe": {"cell": "hexahedron", "degree": degree, "elements": elements},
            "iga": {"degree": [degree] * 3, "elements": elements},
        },
    }


def kappas(bodies, contacts):
    data = {
        "name": "cube",
        "bodies": bodies,
        "contacts": contacts,
        "analysis": {"kind": "cea", "max_frequency": HIGHEST},
    }
    result = run_modes(read_scene(data))
    assert result.modes.window.complete
    return (2 * np.pi * result.frequencies) ** 2


def error(found):
    """Largest relative error over the modes, which are all there."""
    expected = exact()
    assert len(found) == len(expected) == 8
    return float(np.abs(np.sort(found) / expected - 1).max())


def cut_error(backends, degree, refined):
    upper, lower = ([refined * n for n in each] for each in (UPPER, LOWER))
    bodies = {
        "upper": half(backends[0], [1, 1, 1 - CUT], [0, 0, CUT], upper, degree, "z_min"),
        "lower": half(backends[1], [1, 1, CUT], [0, 0, 0], lower, degree, "z_max"),
    }
    joint = {
        "a": "upper.z_min",
        "b": "lower.z_max",
        "formulation": {"method": "bonded"},
        "P": float("inf"),
        "form": "saddle",
    }
    return error(kappas(bodies, {"joint": joint}))


def uncut_error(backend, degree, refined):
    """Error of the cube in one piece, with the coarser half's elements."""
    elements = [refined * n for n in (2, 2, 2)]
    return error(kappas({"cube": half(backend, [1, 1, 1], [0, 0, 0], elements, degree, "")}, {}))


@pytest.mark.parametrize(
    "sides",
    [
        ("iga", "fe"),
        pytest.param(("fe", "fe"), marks=pytest.mark.slow),
        pytest.param(("iga", "iga"), marks=pytest.mark.slow),
    ],
)
def test_a_cube_cut_and_bonded_converges_to_the_uncut_one(sides):
    """Two meshes; the error of the finer one is no larger than that of the uncut cube there."""
    coarse, fine = (cut_error(sides, 2, refined) for refined in (1, 2))
    assert fine <= max(uncut_error(side, 2, 2) for side in sides)
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.4)
