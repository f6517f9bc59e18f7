"""Error bars, picture and page of a brake of mixed elements with anisotropic pads, from a deck."""

import mixed_brake
import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from comparisons.cli.app import app
from scenes import read_scene, run_modes
from scenes.spec.plain import scene_text

LINING = {
    "kind": "orthotropic",
    "E_1": 8e9,
    "E_3": 1.2e9,
    "nu_12": 0.25,
    "nu_13": 0.2,
    "G_13": 1e9,
    "rho": 2500.0,
    "axes": {"cylindrical_about": [0, 0, 1]},
}
"""Friction material: soft across the lining, stiff in its plane."""


def brake(folder, size, degree):
    """The brake with elements of a size (m) and the degree of its displacements."""
    file = folder / f"brake{size}.inp"
    file.write_text(mixed_brake.brake(size))
    given = mixed_brake.scene(file, friction=0.5, top=9000.0)
    given["bodies"]["pad"]["material"] = LINING
    for body in given["bodies"].values():
        body["mesh"] = {"degree": degree}
    return read_scene(given)


@pytest.mark.slow
def test_finer_meshes_by_hand_lie_in_the_bars(tmp_path):
    """Two digits of every mode and of the growth: a higher degree, and smaller elements.

    Smaller elements have other curved faces, which changes frequencies by 1e-6: more than the
    narrowest of the bars, and less than that of the unstable mode.
    """
    file = tmp_path / "brake.toml"
    file.write_text(scene_text(brake(tmp_path, 0.012, 2)))
    bars, run = tmp_path / "bars", tmp_path / "run"
    digits = ["--digits", "2", "--growth-digits", "2", "--backend", "fe"]
    for command in (
        ["converge", str(file), *digits, "--out", str(bars)],
        ["run", str(file), "--set", "output.pictures=1", "--out", str(run)],
    ):
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 0, done.output
    assert "▲ unstable" in (bars / "report.html").read_text()
    assert [file.name for file in run.glob("*.png")] == ["mode_fe_7.png"]

    found = pd.read_csv(bars / "modes.csv")
    assert (found["verdict"] == "▲ unstable").sum() == 1
    for size, degree, compared in ((0.012, 4, found), (0.008, 3, found[found["growth"] != 0])):
        modes = run_modes(brake(tmp_path, size, degree)).modes
        order = np.lexsort((modes.growth_rates, modes.frequencies.round(3)))[compared.index]
        frequencies = np.abs(compared["frequency"] - modes.frequencies[order])
        assert (frequencies < compared["frequency_bar"]).all()
        growths = np.abs(compared["growth"] - modes.growth_rates[order])
        assert (growths <= compared["growth_bar"]).all()
    assert (found["frequency_bar"] < 0.005 * found["frequency"]).all()
    grows = found[found["growth"] > 0]
    assert (grows["growth_bar"] < 0.005 * grows["growth"]).all()
