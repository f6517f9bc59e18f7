"""Decks that CalculiX runs, where it is installed: its modes are ours."""

import decks
import numpy as np
import pytest
from bodies import lagrange_body
from deck_scenes import ELEMENTS, ROUND, SLIDING, alone, in_contact

from comparisons.bench import ccx
from scenes import run_modes
from scenes.building.build import body_mesh
from scenes.export.decks.write import write_deck

MASS = {"C3D8": None, "C3D10": 2, "C3D4": 1, "CPE4": None}
"""Degree to which CalculiX integrates the mass; None, exactly."""


def ours(scene, quadrature, top):
    """Frequencies of this program up to one, with the mass of another."""
    scene = scene.change("analysis.max_frequency", top)
    bodies = {
        name: lagrange_body(
            name,
            body_mesh(name, spec, ()),
            degree=spec.fe_degree,
            material=spec.material,
            supports=[support.support() for support in spec.supports],
            mass_quadrature=quadrature,
        )
        for name, spec in scene.bodies.items()
    }
    return run_modes(scene, bodies=bodies).eigenvalues


IN_SPACE = {"round": ROUND, "sliding": SLIDING}
CASES = [
    pytest.param(name, supports, id=f"{name}-{kind}")
    for name in MASS
    for kind, supports in ({"held": None} | ({} if name.startswith("CPE") else IN_SPACE)).items()
]
"""Elements and supports."""


@pytest.mark.parametrize(("name", "supports"), CASES)
def test_calculix_finds_the_same_frequencies(name, supports, tmp_path):
    decks.with_calculix()
    cell, degree = ELEMENTS[name]
    scene = alone(cell, degree, supports=supports)
    # The last of its list have not always converged, and one may be missing.
    found = ccx.run(write_deck(scene, tmp_path, 16)[1]).imag[:8]
    values = ours(scene, MASS[name], 1.01 * found[-1] / (2 * np.pi)).imag
    assert found == pytest.approx(np.sort(values)[:8], rel=1e-8 if supports else 1e-10)


def test_calculix_finds_the_same_flutter(tmp_path):
    decks.with_calculix()
    scene = in_contact()
    found = ccx.run(write_deck(scene, tmp_path, 20)[1])
    values = ours(scene, 2, 1.01 * found.imag[-1] / (2 * np.pi))
    (theirs,) = found[found.real > 1]
    (own,) = values[values.real > 1]
    assert theirs.imag == pytest.approx(own.imag, rel=1e-5)
    assert theirs.real == pytest.approx(own.real, rel=1e-3)


def test_friction_pushes_the_pad_as_the_scene_says(tmp_path):
    """No spectrum tells the sign: forces of the static step do."""
    decks.with_calculix()
    deck = write_deck(in_contact(), tmp_path, 4)[1]
    ccx.run(deck)
    listed = deck.with_suffix(".dat").read_text().split("total surface force")[1].splitlines()
    force = np.array(listed[2].split()[:3], dtype=float)
    middle = np.array([-1.0, 1.0]) / np.sqrt(2)  # circumferential, in the middle of the pad
    size = 4 / np.radians(40) * np.sin(np.radians(20)) / 2  # of the mean direction over 40 degrees
    assert force[2] > 0  # the disc pushes the pad up
    assert force[:2] @ middle == pytest.approx(2 * 0.7 * force[2] * size, rel=0.02)
