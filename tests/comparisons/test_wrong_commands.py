"""Wrong command lines and files: refused in a line that names what is wrong, with code 1 or 2."""

import shlex

import pytest
from bad_inputs import TABLE


@pytest.mark.parametrize(("line", "field", "word"), TABLE["commands"]["lines"])
def test_a_wrong_command_names_what_is_wrong(line, field, word, cea, tmp_path):
    code, _, told = cea(*shlex.split(line))
    assert code in (1, 2)
    assert "Traceback" not in told
    lines = [each for each in told.splitlines() if field in each and word in each]
    assert lines, told
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
