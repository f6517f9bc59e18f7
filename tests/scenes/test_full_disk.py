"""Every writer of a run tells a full disk, and leaves nothing half written."""

import pytest
from blocks import two_blocks
from disks import full_disk

from cea.errors import WriteError
from scenes import read_scene, run_modes, save_result

GPTS = {"method": "gpts", "points": 3}


@pytest.fixture(scope="module")
def result():
    return run_modes(read_scene(two_blocks("iga", GPTS, held=True)))


def everything(folder):
    return sorted(str(each.relative_to(folder)) for each in folder.rglob("*"))


def paraview(result, out):
    from scenes.export.paraview import write_paraview

    write_paraview(result, 2, out)


def pictures(result, out):
    from scenes.export.pictures import draw_modes

    draw_modes(result, 1, out, animated=True)


def record(result, out):
    save_result(result, out / "result.json")


def plot(result, out):
    from matplotlib.figure import Figure

    from comparisons.kit.plots import save

    save(Figure(), out / "figure.png")


@pytest.mark.parametrize(
    "write", [paraview, pytest.param(pictures, marks=pytest.mark.slow), record, plot]
)
def test_a_full_disk_is_told_and_leaves_nothing(write, result, tmp_path):
    out = tmp_path / "out"
    with full_disk(200), pytest.raises(WriteError, match="cannot be written: File too large"):
        write(result, out)
    assert everything(out) == []
    write(result, out)
    before = {each: each.read_bytes() for each in out.rglob("*") if each.is_file()}
    assert before
    with full_disk(200), pytest.raises(WriteError):
        write(result, out)
    assert {each: each.read_bytes() for each in out.rglob("*") if each.is_file()} == before
