"""A brake whose disc has wedges at its hub, beside hexahedra alone and beside CalculiX."""

import shutil
import subprocess

import numpy as np
import pytest
from mixed_brake import Brake, calculix, scene
from mpi import on_ranks

from scenes.read import read_scene
from scenes.run import run_modes

COUNT = 20


def modes(folder, size, order, *, wedges, friction):
    file = folder / f"brake{size}{order}{wedges}.inp"
    file.write_text(Brake(size, order, wedges=wedges).deck())
    result = run_modes(read_scene(scene(file, friction=friction)))
    assert ("mixed elements" in result.skipped) == wedges
    return np.sort(result.modes.frequencies)[:COUNT], sum(
        verdict == "unstable" for verdict in result.modes.verdicts()
    )


@pytest.mark.parametrize("ranks", [2, 3])
def test_a_divided_body_is_the_same_on_any_number_of_ranks(ranks):
    alone, spread = (on_ranks(n, "mixed_brake.on_any_number_of_ranks") for n in (1, ranks))
    assert len(alone["re"]) > 2
    for part in ("re", "im"):
        np.testing.assert_allclose(spread[part], alone[part], rtol=0, atol=1e-6 * max(alone["im"]))


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_wedges_at_the_hub_change_little_and_less_on_finer_meshes(tmp_path, order):
    apart = []
    for size in (0.008, 0.005):
        (mixed, unstable), (whole, expected) = (
            modes(tmp_path, size, order, wedges=wedges, friction=0.6) for wedges in (True, False)
        )
        assert len(mixed) == len(whole) == COUNT
        assert unstable == expected > 0
        apart.append(np.abs(mixed / whole - 1).max())
    assert apart[0] < 0.01
    assert apart[1] < apart[0] / 2


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.008, 0.005])
def test_a_bonded_brake_has_the_frequencies_of_calculix(tmp_path, size):
    if shutil.which("ccx") is None:
        pytest.skip("ccx is not installed")
    (tmp_path / "job.inp").write_text(calculix(Brake(size, 2, wedges=True, bonded=True), COUNT))
    subprocess.run(["ccx", "-i", "job"], cwd=tmp_path, capture_output=True, check=True)
    rows = [line.split() for line in (tmp_path / "job.dat").read_text().splitlines()]
    theirs = np.array([float(row[3]) for row in rows if len(row) == 5 and row[0].isdecimal()])
    ours, _ = modes(tmp_path, size, 2, wedges=True, friction=0.0)
    assert len(theirs) >= COUNT
    assert np.abs(ours / theirs[:COUNT] - 1).max() < 0.01
