"""Tables of modes: signs, rigid motions, marks, and pandas where there is some."""

from math import inf

import numpy as np
import pytest
from blocks import two_blocks

from cea.eigen.spectrum import Spectrum, Window
from cea.mode_table import shown_cells
from scenes import read_scene, run_modes

WINDOW = Window(100.0, 1e5, inf, 5, 1, inf, True, False, 4e5, 5, None)
OMEGA = 200.0


def spectrum(values, uncertainties):
    n = len(values)
    return Spectrum(np.array(values), np.zeros(n), np.ones(n), np.array(uncertainties), WINDOW)


def test_damping_ratios_are_those_of_an_oscillator():
    """X'' + 2 zeta omega x' + omega^2 x = 0, of both signs, and beyond critical damping."""
    zetas = np.array([0.05, -0.05, 1e-5])
    values = OMEGA * (-zetas + 1j * np.sqrt(1 - zetas**2))
    modes = spectrum([*values, -30.0 + 0j], np.full(4, 1e-9))
    np.testing.assert_allclose(modes.damping_ratios, [*zetas, 1.0], rtol=1e-12)
    assert [row["damping_ratio"] for row in modes.table()] == modes.damping_ratios.tolist()
    assert [row["verdict"] for row in modes.table()] == ["stable", "unstable", "stable", "stable"]


def test_what_nothing_holds_is_rigid_and_has_no_damping_ratio():
    modes = spectrum([0j, 1e-6 + 0j, 1e-3 + 0j, 50j, 60j], [1e-9, 2e-6, 1e-6, 1e-6, 70.0])
    assert modes.rigid.tolist() == [True, True, False, False, False]
    assert np.isnan(modes.damping_ratios[:2]).all()
    assert [row["damping_ratio"] for row in modes.table()][:2] == [None, None]
    assert np.isnan(modes.table().column("damping_ratio")[:2]).all()
    assert modes.verdicts() == ["rigid", "rigid", "unstable", "undecided", "undecided"]
    for part in ("5 modes up to 100 Hz", "1 unstable", "2 rigid"):
        assert part in modes.headline()


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_two_free_blocks_in_contact_have_nine_rigid_motions(backend, mu):
    """Twelve rigid motions, of which the contact holds one displacement and two tilts."""
    data = two_blocks(backend, {"method": "gpts", "points": 3}, mu=mu)
    data["analysis"]["max_frequency"] = 0.4
    result = run_modes(read_scene(data))
    assert np.flatnonzero(result.modes.rigid).tolist() == list(range(9))
    assert "9 rigid" in result.summary
    cells = shown_cells(result.table())
    assert all(cell["verdict"] == "rigid" for cell in cells[:9])
    assert {cell["damping_ratio"] for cell in cells[:9]} == {"-"}
    assert cells[9]["verdict"] == "stable"
    assert result.title(8).endswith("mode 9: rigid motion")
    assert "mode 10: 0." in result.title(9)
