"""A brake whose disc has wedges at its hub: bonded beside CalculiX, sliding on several ranks."""

import subprocess

import numpy as np
import pytest
from decks import with_calculix
from mixed_brake import MATERIALS, brake, scene
from mpi import cea_on_ranks

from scenes import open_result, run_modes
from scenes.spec.plain import scene_text
from scenes.spec.reading import read_scene

COUNT = 20


def job(size):
    """The deck of the same for CalculiX, held at the bore and behind."""
    lines = []
    for part, (E, nu, rho) in MATERIALS.items():
        lines += [f"*MATERIAL, NAME={part}", "*ELASTIC", f"{E}, {nu}", "*DENSITY", f"{rho}"]
        lines += [f"*SOLID SECTION, ELSET={part}, MATERIAL={part}"]
    lines += ["*BOUNDARY", "BORE, 1, 3", "BACK, 1, 3"]
    lines += ["*STEP", "*FREQUENCY, STORAGE=YES", f"{COUNT}", "*END STEP"]
    return brake(size, shared=True) + "\n".join(lines) + "\n"


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.008, 0.005])
def test_a_bonded_brake_has_the_frequencies_of_calculix(tmp_path, size):
    with_calculix()
    (tmp_path / "job.inp").write_text(job(size))
    subprocess.run(["ccx", "-i", "job"], cwd=tmp_path, capture_output=True, check=True)
    rows = [line.split() for line in (tmp_path / "job.dat").read_text().splitlines()]
    theirs = np.array([float(row[3]) for row in rows if len(row) == 5 and row[0].isdecimal()])
    assert len(theirs) >= COUNT
    file = tmp_path / "brake.inp"
    file.write_text(brake(size))
    result = run_modes(read_scene(scene(file)))
    assert "mixed elements" in result.skipped
    ours = np.sort(result.modes.frequencies)[:COUNT]
    assert np.abs(ours / theirs[:COUNT] - 1).max() < 0.01


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_bodies_from_a_file_are_the_same_on_several_ranks(tmp_path, ranks):
    deck, file, found = tmp_path / "brake.inp", tmp_path / "brake.toml", []
    deck.write_text(brake(0.03))
    file.write_text(scene_text(read_scene(scene(deck, friction=0.6, top=9000.0))))
    for count in (1, ranks):
        out = tmp_path / str(count)
        done = cea_on_ranks(count, "run", file, "--out", out)
        assert done.returncode == 0, done.stderr
        found.append(open_result(out / "result.json").eigenvalues)
    assert len(found[0]) > 6
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-9 * np.abs(found[0]).max())
