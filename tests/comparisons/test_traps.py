"""What ended in a traceback, never ended, or took what was not meant: told in a line, or right."""

import json
import os
import subprocess
import sys

import pytest
from blocks import two_blocks

from cea.errors import InputError, printable
from cea.files import check_writable, regular
from comparisons.sweep.points import read_axis
from meshes.files.reading import read_mesh_file
from scenes.results.record import read_record
from scenes.spec.plain import scene_text
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene

ENDS = "import sys; sys.argv[0] = 'cea'\nfrom comparisons.cli.app import main\nmain()"


@pytest.fixture
def scene_file(tmp_path):
    """Writes a small scene of a name to a file of its own."""

    def write(file, name):
        data = two_blocks("iga", {"method": "gpts", "points": 3}, held=True) | {"name": name}
        (tmp_path / file).write_text(scene_text(read_scene(data)))
        return file

    return write


@pytest.fixture
def pipe(tmp_path):
    """A pipe, which stands for every file that is none: reading it would wait for ever."""
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


def test_only_regular_files_are_read(pipe, tmp_path):
    with pytest.raises(OSError, match="not a regular file"):
        regular(pipe)
    assert regular(tmp_path / "none") == tmp_path / "none"
    for read in (read_mesh_file, load_scene, read_record):
        link = tmp_path / f"link{'.inp' if read is read_mesh_file else '.toml'}"
        link.unlink(missing_ok=True)
        link.symlink_to(pipe)
        with pytest.raises((InputError, SceneError), match="not a regular file"):
            read(link)


def test_what_is_no_file_is_not_written_over(cea, pipe):
    with pytest.raises(InputError, match="not a regular file"):
        check_writable(pipe, "out")
    for command in ("schema", "reference"):
        code, _, told = cea("scene", command, "--out", pipe)
        assert (code, told) == (1, f"error: out = '{pipe}': a file to write (not a regular file)\n")
    assert pipe.exists()
    assert not pipe.is_file()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device that is full")
def test_a_full_standard_output_ends_in_a_line():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", ENDS, "scene", "list"],
            stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == "error: output cannot be written: No space left on device\n"


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (("run", "blocks", "--out", ""), "out"),
        (("run", "blocks", "--out="), "out"),
        (("run", ""), "argument"),
        (("run", "blocks", "--set", ""), "set"),
        (("sweep", "blocks", "mu=0:1:3", "--data", ""), "data"),
        (("scene", "check", "blocks", "--out", ""), "out"),
        (("exact", "drum", "--json", ""), "json"),
    ],
)
def test_empty_arguments_are_refused(arguments, field, cea, tmp_path):
    code, _, told = cea(*arguments)
    assert (code, told) == (1, f"error: {field} = '': something that is not empty\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "axis",
    ["mu=1e-320:1e308:log:5", "mu=0:1e308:3", "mu=-1e308:0:3", "P=1e-31:1.0:log:3", "mu=0:nan:3"],
)
def test_ends_of_axes_are_numbers_that_fields_may_have(axis):
    with pytest.raises(InputError, match=r"1e[+-]30"):
        read_axis(axis)


def test_results_of_another_scene_stay(cea, scene_file, tmp_path):
    one, other = scene_file("one.toml", "same"), scene_file("other.toml", "same")
    out = tmp_path / "results" / "same"

    def stored(folder):
        return json.loads((folder / "result.json").read_text())["inputs"]["scene"]

    assert cea("run", one)[0] == 0
    assert cea("run", one, "--set", "contacts.interface.mu=0.1")[0] == 0
    for given in ((), ("--out", out)):
        code, _, told = cea("run", other, *given)
        assert code == 1
        assert "result of another scene, 'one.toml'; --overwrite" in told
        assert stored(out) == "one.toml"
    assert cea("run", other, "--overwrite")[0] == 0
    assert stored(out) == "other.toml"


def test_results_of_another_command_stay(cea, scene_file, tmp_path):
    file = scene_file("mine.toml", "sweep")
    steps = "bodies.upper.material.nu=0.1:0.2:2"
    assert cea("sweep", file, steps, "--full")[0] == 0
    code, _, told = cea("run", file)
    assert code == 1
    assert "result of another command, 'sweep'" in told


INCLUDE = "*NODE\n1, 0.0, 0.0, 0.0\n*INCLUDE, INPUT=pipe\n"


XDMF = """<Xdmf Version="3.0"><Domain><Grid><Topology TopologyType="Tetrahedron">
<DataItem Dimensions="1 4">0 1 2 3</DataItem></Topology><Geometry>
<DataItem Dimensions="4 3" Format="{}">pipe{}</DataItem></Geometry></Grid></Domain></Xdmf>"""


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("deck.inp", INCLUDE),
        ("mesh.xdmf", XDMF.format("HDF", ":/points")),
        ("mesh.xdmf", XDMF.format("Binary", "")),
    ],
    ids=["include", "hdf", "binary"],
)
def test_files_that_name_a_device_end(name, text, pipe, tmp_path):
    """In a program of its own: a reader that waits for a pipe hears of no alarm."""
    (tmp_path / name).write_text(text)
    program = (
        f"from pathlib import Path\nfrom meshes.files.reading import read_mesh_file\n"
        f"read_mesh_file(Path({str(tmp_path / name)!r}))"
    )
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    assert done.stderr.splitlines()[-1].startswith("cea.errors.InputError: file = ")
    assert "not a regular file" in done.stderr or "no device or folder" in done.stderr


def test_signs_that_terminals_obey_are_written_out():
    assert printable("a\x1b[2J\r\x9bb\n") == "a\\x1b[2J\\r\\x9bb\n"
    assert printable("µ = 0.3 → ±") == "µ = 0.3 → ±"
