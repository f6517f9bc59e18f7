"""Folders of results: refused before the work, replaced as a whole, nobody's own files lost."""

import json
import os

import pytest

from cea.errors import InputError, WriteError
from scenes.results.folder import MANIFEST, RESULT, check_out, listed, new_folder
from scenes.results.record import record, write_record


def fill(out, files):
    """Write a result with some files; what was kept."""
    with new_folder(out) as new:
        for name, content in files.items():
            file = new.part / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content)
        write_record(record("run", {}, inputs={}, seconds=1.0), new.part / RESULT)
    return new.kept


def content(out):
    files = (file for file in out.rglob("*") if file.is_file())
    found = {file.relative_to(out).as_posix(): file.read_text() for file in files}
    return {name: text for name, text in found.items() if name not in (RESULT, MANIFEST)}


def test_a_result_takes_the_place_of_an_earlier_one(tmp_path):
    assert fill(tmp_path, {"mode_1.png": "a", "modes/mode_1.vtu": "b", "modes/old/x": "c"}) == []
    assert listed(tmp_path) == ["mode_1.png", "modes/mode_1.vtu", "modes/old/x", RESULT]
    assert fill(tmp_path, {"mode_2.png": "d", "modes/mode_2.vtu": "e"}) == []
    assert content(tmp_path) == {"mode_2.png": "d", "modes/mode_2.vtu": "e"}
    assert not (tmp_path / "modes" / "old").exists()
    assert fill(tmp_path, {}) == []
    assert sorted(os.listdir(tmp_path)) == [MANIFEST, RESULT]


def test_what_others_wrote_stays(tmp_path):
    fill(tmp_path, {"mode_1.png": "a", "modes/mode_1.vtu": "b"})
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "mode_2.png").write_text("painted")
    (tmp_path / "modes" / "own.vtu").write_text("mine too")
    assert fill(tmp_path, {"mode_2.png": "c"}) == ["mode_2.png.kept1"]
    kept = {"notes.txt": "mine", "mode_2.png.kept1": "painted"}
    assert content(tmp_path) == kept | {"modes/own.vtu": "mine too", "mode_2.png": "c"}
    assert fill(tmp_path, {"modes": "a file"}) == ["modes.kept1"]
    assert content(tmp_path) == kept | {"modes.kept1/own.vtu": "mine too", "modes": "a file"}


def test_a_list_names_no_files_outside_its_folder(tmp_path):
    out = tmp_path / "out"
    fill(out, {})
    victim = tmp_path / "victim"
    victim.write_text("")
    (out / MANIFEST).write_text(json.dumps({"files": ["../victim", str(victim), "a/../../victim"]}))
    fill(out, {})
    assert victim.exists()
    for i, broken in enumerate(("", "[]", '{"files": 3}', '{"files": [3]}')):
        (out / MANIFEST).write_text(broken)
        assert fill(out, {"a": str(i)}) == ([f"a.kept{i}"] if i else [])


def test_what_fails_leaves_the_earlier_result(tmp_path):
    fill(tmp_path, {"mode_1.png": "a"})
    before = {file: file.read_bytes() for file in tmp_path.rglob("*")}
    with pytest.raises(TypeError, match="must be str"):
        fill(tmp_path, {"mode_1.png": "half", "mode_2.png": b"no text"})
    with pytest.raises(WriteError) as caught, new_folder(tmp_path) as new:
        raise WriteError(f"{new.part}/mode_1.png cannot be written: no space")
    assert str(caught.value) == f"{tmp_path}/mode_1.png cannot be written: no space"
    assert {file: file.read_bytes() for file in tmp_path.rglob("*")} == before


def test_folders_that_cannot_take_a_result_are_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    for out in (file, file / "inside", file / "inside" / "deeper"):
        with pytest.raises(InputError, match=r"out = .*a folder to write to"):
            check_out(out)
    with pytest.raises(InputError, match=r"out = .*a folder to write to"):
        check_out(tmp_path / ("x" * 300))
    for content_of_it in ("mine", "{}", '{"command": "run"}'):
        (tmp_path / RESULT).write_text(content_of_it)
        with pytest.raises(InputError, match=r"out = .*a folder without a result\.json"):
            check_out(tmp_path)
    (tmp_path / RESULT).unlink()
    (tmp_path / RESULT).mkdir()
    with pytest.raises(InputError, match=r"out = .*a folder without a result\.json"):
        check_out(tmp_path)
    assert file.read_text() == "mine"
