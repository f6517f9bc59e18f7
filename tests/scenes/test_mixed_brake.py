"""A brake whose disc has wedges at its hub, beside hexahedra alone and beside CalculiX."""

import shutil
import subprocess

import numpy as np
import pytest
from mixed_brake import Brake, calculix, scene

from scenes import run_modes
from scenes.spec.reading import read_scene

COUNT = 20


def modes(folder, size, order, *, wedges, friction):
    file = folder / f"brake{size}{order}{wedges}.inp"
    file.write_text(Brake(size, order, wedges=wedges).deck())
    result = run_modes(read_scene(scene(file, friction=friction)))
    assert ("mixed elements" in result.skipped) == wedges
    return np.sort(result.modes.frequencies)[:COUNT], sum(
        verdict == "unstable" for verdict in result.modes.verdicts()
    )


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
