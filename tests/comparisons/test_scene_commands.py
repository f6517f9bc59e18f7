"""Commands that look at scenes, run nothing, and tell what a run would do."""

import re

import pytest
from mpi import cea_on_ranks
from PIL import Image

from cea import __version__
from scenes.spec.plain import matrix_scene_names, scene_names


def test_version(cea):
    assert cea("--version") == (0, f"friction-cea {__version__}\n", "")


def test_list_names_every_scene_in_a_line(cea):
    code, out, _ = cea("scene", "list")
    assert code == 0
    _, _, table = out.rpartition("─")
    lines = [line.strip() for line in table.splitlines() if line.strip()]
    assert [line.split()[0] for line in lines] == [*scene_names(), *matrix_scene_names()]
    (line,) = (line for line in lines if line.startswith("disc_pad "))
    assert "pad, disc" in line
    assert "A steel disc clamped at its inner rim" in line
    assert float(line.split()[1]) == pytest.approx(18696, rel=0.1)


def test_check_tells_size_and_draws(cea, tmp_path):
    code, out, err = cea("scene", "check", "blocks", "--out", tmp_path)
    assert (code, err) == (0, "")
    assert "920 unknowns" in out
    assert "no faults" in out
    assert re.search("left out, not needed: .*newton.*loads", out)
    assert str(tmp_path / "blocks.png") in out
    assert Image.open(tmp_path / "blocks.png").size == (2200, 900)


def test_check_tells_every_fault(cea, tmp_path):
    wrong = ["--set", "contacts.interface.mue=1", "--set", "bodies.upper.material.E=-1"]
    code, _, err = cea("scene", "check", "blocks", *wrong, "--out", tmp_path)
    assert code == 1
    assert [line.split(" = ")[0] for line in err.splitlines()] == [
        "error: bodies.upper.material.E",
        "error: contacts.interface.mue",
    ]
    tilted = ["--set", "bodies.upper.placement={angle=1.0}", "--no-picture"]
    code, _, err = cea("scene", "check", "blocks", *tilted, "--out", tmp_path)
    assert code == 1
    assert "tilted by up to 1 degrees" in err
    assert not list(tmp_path.iterdir())


def test_check_of_matrices(cea, tmp_path):
    code, _, err = cea("scene", "check", "tu_berlin", "--data", tmp_path)
    assert code == 1
    assert err.startswith("error: files.")


@pytest.mark.mpi
def test_check_on_two_ranks_is_told_once(tmp_path):
    done = cea_on_ranks(2, "scene", "check", "blocks", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("920 unknowns") == 1
    assert "168 points (168 inside)" in done.stdout
    assert (tmp_path / "blocks.png").is_file()
