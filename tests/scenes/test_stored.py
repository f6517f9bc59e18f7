"""Records of commands: whole or not at all, with what made them, and opened again as results."""

from dataclasses import asdict
from math import inf
from pathlib import Path

import numpy as np
import pytest
from blocks import two_blocks

from cea.errors import InputError
from scenes import open_result, read_scene, run_modes, run_static, save_result
from scenes.results.record import commit, read_record, record, write_record

GPTS = {"method": "gpts", "points": 3}


def test_modes_open_as_they_were(backend, tmp_path):
    data = two_blocks(backend, GPTS, held=True, P=inf)
    data["contacts"]["interface"]["form"] = "saddle"
    result = run_modes(read_scene(data))
    opened = open_result(save_result(result, tmp_path / "sub" / "result.json"))
    assert opened.scene == result.scene
    assert inf == opened.scene.contacts["interface"].P
    for name in ("eigenvalues", "frequencies", "growth_rates", "unstable"):
        np.testing.assert_array_equal(getattr(opened, name), getattr(result, name))
    for name in ("residuals", "conditions", "growth_uncertainties"):
        np.testing.assert_array_equal(getattr(opened.modes, name), getattr(result.modes, name))
    assert asdict(opened.modes.window) == asdict(result.modes.window)
    assert opened.modes.window.evidence == result.modes.window.evidence
    assert opened.table() == result.table()
    assert str(opened) == str(result)
    assert opened.dofs == result.system.size
    assert opened.timer.seconds == result.timer.seconds
    assert opened.provenance["seconds"] == result.timer.total
    assert opened.skipped == result.skipped
    with pytest.raises(InputError, match="a fresh run"):
        opened.matrices()


def test_a_static_run_opens_with_its_stresses(tmp_path):
    data = two_blocks("iga", GPTS, held=True, mu=0.0)
    data |= {"analysis": {"kind": "static", "samples": 4}}
    result = run_static(read_scene(data))
    opened = open_result(save_result(result, tmp_path / "result.json.gz"))
    assert opened.scene == result.scene
    for side, stress in result.stresses["interface"].items():
        found = opened.stresses["interface"][side]
        assert found.oscillation == stress.oscillation
        assert (found.min, found.max) == (stress.sigma_n.min(), stress.sigma_n.max())
        np.testing.assert_array_equal(found.arc, stress.arc)
        np.testing.assert_array_equal(found.sigma_n_along, stress.sigma_n_along)


def made(**data):
    return record("count", data, inputs={"n": 3}, seconds=1.5, warnings=[{"kind": "few"}])


@pytest.mark.parametrize("name", ["result.json", "result.json.gz"])
def test_any_record_opens(name, tmp_path):
    file = write_record(made(numbers=[1, 2.5, inf, -inf, None], words={"a": "b"}), tmp_path / name)
    opened = open_result(str(file))
    made_by = opened.provenance
    assert opened.scene is None
    assert (made_by["command"], made_by["inputs"], made_by["seconds"]) == ("count", {"n": 3}, 1.5)
    assert made_by["warnings"] == ({"kind": "few"},)
    assert {"python", "petsc", "numpy"} <= set(made_by["versions"])
    assert made_by["commit"] == commit()
    assert made_by["machine"]["cpus"] >= 1
    assert opened.data == {"numbers": [1, 2.5, inf, -inf, None], "words": {"a": "b"}}


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    file = write_record({"n": 1}, tmp_path / "r.json")
    with pytest.raises(ValueError, match="JSON"):
        write_record({"n": float("nan")}, file)

    def fails(self, target):
        raise OSError("no space left")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", fails)
        with pytest.raises(OSError, match="no space"):
            write_record({"n": 2}, file)
    assert read_record(file) == {"n": 1}
    assert [each.name for each in tmp_path.iterdir()] == ["r.json"]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("r.json", None),
        ("r.json", b""),
        ("r.json", b"{"),
        ("r.json", b"[1]"),
        ("r.json", b'{"eigenvalues": []}'),
        ("r.json.gz", b"\x1f\x8b broken"),
    ],
)
def test_what_is_no_record_is_refused(content, name, tmp_path):
    file = tmp_path / name
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match=r"file = .*a stored result"):
        open_result(file)
