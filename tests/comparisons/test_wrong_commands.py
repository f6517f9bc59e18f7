"""Wrong command lines and files: refused in a line that names what is wrong, with code 1 or 2."""

import shlex

import pytest
from bad_inputs import TABLE


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
