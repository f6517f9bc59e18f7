"""Commands that are wrong as people get them wrong: refused in a line that names what is wrong."""

import json
import os
import shlex
import subprocess
import sys

import pytest
from bad_inputs import TABLE
from blocks import coarse, two_blocks

from cea.errors import InputError, printable
from cea.files import check_writable, regular
from comparisons.cli import options as extras
from meshes.files.reading import read_mesh_file
from scenes import SceneError, load_scene, read_scene
from scenes.results.record import read_record
from scenes.spec.plain import scene_text


@pytest.mark.parametrize(
    ("kind", "line", "field", "word"),
    [(kind, *row) for kind, rows in TABLE["commands"].items() for row in rows],
)
def test_a_wrong_command_names_what_is_wrong(kind, line, field, word, cea, tmp_path):
    """In one line, where a scene has several faults in one for each; code 2 is of usage."""
    code, _, told = cea(*shlex.split(line))
    assert code == (2 if kind == "usage" else 1)
    lines = told.splitlines()
    if kind == "usage":
        assert "Traceback" not in told
        assert any(field in each and word in each for each in lines), told
    else:
        assert lines[0].startswith(f"error: {field} = "), told
        assert word in lines[0]
        several = [each for each in lines if each.startswith("error: ")]
        assert lines == (several if kind == "several" else lines[:1]), told
    assert not list(tmp_path.glob("results/*/result.json"))


@pytest.mark.parametrize(("text", "field", "word"), TABLE["files"]["texts"])
def test_a_wrong_file_names_what_is_wrong(text, field, word, cea, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(text)
    code, _, told = cea("scene", "check", file, "--out", tmp_path)
    assert code == 1
    lines = [each for each in told.splitlines() if each.startswith(f"error: {field} = ")]
    assert any(word in each for each in lines), told
    assert len(told.splitlines()) <= 8


@pytest.mark.parametrize(
    ("line", "module", "extra"),
    [
        ("exact drum --m 2", "flint", "exact"),
        ("paper 3 --out .", "matplotlib", "pictures"),
        ("study accuracy --out .", "flint", "exact"),
        ("run disc --set output.pictures=1 --out .", "pyvista", "pictures"),
    ],
)
def test_a_missing_extra_is_told_in_one_line(line, module, extra, monkeypatch, cea, tmp_path):
    found = extras.find_spec
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == module else found(name))
    code, _, told = cea(*line.split())
    assert code == 1
    (line,) = told.splitlines()
    assert line.startswith("error: ")
    assert module in line
    assert f"friction-cea[{extra}]" in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("line", "field"),
    [("interface.mu=0:1:3 --seed 0", "seed"), ("interface.mu~uniform:0:1 --confirm 0", "confirm")],
)
def test_an_option_of_another_kind_of_sweep_is_refused_even_if_zero(line, field, cea, tmp_path):
    code, _, told = cea("sweep", "blocks", *line.split())
    assert code == 1
    assert told.startswith(f"error: {field} = 0: left out ")
    assert list(tmp_path.iterdir()) == []


def test_results_of_another_scene_or_command_stay(cea, tmp_path):
    data = coarse(two_blocks("iga", {"method": "gpts", "points": 3}, held=True)) | {"name": "same"}
    one, other, out = "one.toml", "other.toml", tmp_path / "results" / "same"
    for file in (one, other):
        (tmp_path / file).write_text(scene_text(read_scene(data)))

    def stored():
        return json.loads((out / "result.json").read_text())["inputs"]["scene"]

    assert cea("run", one)[0] == 0
    assert cea("run", one, "--set", "contacts.interface.mu=0.1")[0] == 0
    for given in ((), ("--out", out)):
        code, _, told = cea("run", other, *given)
        assert code == 1
        assert "result of another scene, 'one.toml'; --overwrite" in told
        assert stored() == "one.toml"
    assert cea("run", other, "--overwrite")[0] == 0
    assert stored() == "other.toml"
    swept = "sweep", one, "bodies.upper.material.nu=0.1:0.2:2", "--full", "--out", "swept"
    assert cea(*swept)[0] == 0
    code, _, told = cea("run", one, "--out", "swept")
    assert code == 1
    assert "result of another command, 'sweep'" in told


@pytest.fixture
def pipe(tmp_path):
    """A pipe, which stands for every file that is none: reading it would wait for ever."""
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


def test_only_regular_files_are_read(pipe, tmp_path):
    with pytest.raises(OSError, match="not a regular file"):
        regular(pipe)
    assert regular(tmp_path / "none") == tmp_path / "none"
    for read, link in ((read_mesh_file, "a.inp"), (load_scene, "a.toml"), (read_record, "b.toml")):
        (tmp_path / link).symlink_to(pipe)
        with pytest.raises((InputError, SceneError), match="not a regular file"):
            read(tmp_path / link)


XDMF = """<Xdmf Version="3.0"><Domain><Grid><Topology TopologyType="Tetrahedron">
<DataItem Dimensions="1 4">0 1 2 3</DataItem></Topology><Geometry>
<DataItem Dimensions="4 3" Format="{}">pipe{}</DataItem></Geometry></Grid></Domain></Xdmf>"""
FILES = {
    "deck.inp": "*NODE\n1, 0.0, 0.0, 0.0\n*INCLUDE, INPUT=pipe\n",
    "hdf.xdmf": XDMF.format("HDF", ":/points"),
    "binary.xdmf": XDMF.format("Binary", ""),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_name_a_device_are_refused(name, pipe, tmp_path):
    (tmp_path / name).write_text(FILES[name])
    with pytest.raises(InputError, match=r"not a regular file|no device or folder"):
        read_mesh_file(tmp_path / name)


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
    ends = "import sys; sys.argv[0] = 'cea'\nfrom comparisons.cli.app import main\nmain()"
    command = [sys.executable, "-c", ends, "scene", "list"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr == "error: output cannot be written: No space left on device\n"


def test_signs_that_terminals_obey_are_written_out():
    assert printable("a\x1b[2J\r\x9bb\n") == "a\\x1b[2J\\r\\x9bb\n"
    assert printable("µ = 0.3 → ±") == "µ = 0.3 → ±"
