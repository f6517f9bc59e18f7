"""What a run gives: shapes, matrices; records, opened again; folders."""

import json
import os
from dataclasses import asdict
from math import inf

import numpy as np
import pytest
from blocks import GPTS, coarse, two_blocks
from motions import mode_displacement
from scipy.linalg import eigvals

from cea.errors import InputError
from scenes import open_result, read_scene, run_modes, run_static, save_result
from scenes.results.folder import MANIFEST, RESULT, check_out, listed, new_folder
from scenes.results.record import commit, read_record, record, write_record


@pytest.fixture(scope="module", params=["fe", "iga"])
def result(request):
    return run_modes(read_scene(coarse(two_blocks(request.param, GPTS, held=True))))


@pytest.mark.parametrize("chosen", [None, [2, 0], np.array([1])])
def test_shapes_are_those_of_one_vector_at_a_time(result, chosen):
    modes = range(len(result.modes)) if chosen is None else chosen
    for name, body in result.bodies.items():
        expected = np.stack([mode_displacement(result, name, i) for i in modes], axis=2)
        small = 1e-13 * np.abs(expected).max()
        found = result.mode_shapes(name, modes=chosen)
        np.testing.assert_allclose(found, expected, atol=small)

        values = body.space.volume_cells().straight().values
        at_points = result.mode_shapes(name, values, chosen, everywhere=False)
        assert at_points.shape == (values.shape[0], 3, len(modes))
        for i in range(len(modes)):
            np.testing.assert_allclose(at_points[..., i], values @ expected[..., i], atol=small)

        points = body.surfaces["z_max"].gauss_points(2)
        on_surface = result.mode_shapes(f"{name}.z_max", points.at, chosen)
        trace = body.surfaces["z_max"].trace(points.at)
        np.testing.assert_array_equal(on_surface, result.mode_shapes(name, trace, chosen))
        np.testing.assert_allclose(on_surface[..., -1], trace @ expected[..., -1], atol=small)


def test_matrices_have_the_eigenvalues(result):
    matrices = result.matrices()
    assert list(matrices) == ["K", "M", "K_n", "K_f"]
    assert {m.shape for m in matrices.values()} == {(result.system.size,) * 2}
    K = (matrices["K"] + matrices["K_n"] - matrices["K_f"]).toarray()
    found = np.sqrt(-eigvals(K, matrices["M"].toarray()).astype(complex))
    found = np.where(found.imag < 0, -found, found)
    for value in result.eigenvalues:
        assert np.abs(found - value).min() < 1e-7 * abs(value)
    inside = (found.imag > 0) & (found.imag < 2 * np.pi * result.analysis.max_frequency)
    assert inside.sum() == len(result.modes)


# Records: whole or not at all, with what made them, and opened again as results.


def test_modes_open_as_they_were(backend, tmp_path):
    data = two_blocks(backend, GPTS, held=True, P=inf)
    data["contacts"]["interface"]["form"] = "saddle"
    result = run_modes(read_scene(data))
    opened = open_result(save_result(result, tmp_path / "sub" / "result.json"))
    assert opened.scene == result.scene
    for name in ("eigenvalues", "frequencies", "growth_rates", "unstable"):
        np.testing.assert_array_equal(getattr(opened, name), getattr(result, name))
    for name in ("residuals", "conditions", "growth_uncertainties"):
        np.testing.assert_array_equal(getattr(opened.modes, name), getattr(result.modes, name))
    assert asdict(opened.modes.window) == asdict(result.modes.window)
    assert opened.table() == result.table()
    assert opened.dofs == result.system.size
    assert opened.skipped == result.skipped
    with pytest.raises(InputError, match="a fresh run"):
        opened.matrices()


def test_a_static_run_opens_with_its_stresses(tmp_path):
    data = two_blocks("iga", GPTS, held=True, mu=0.0)
    result = run_static(read_scene(data | {"analysis": {"kind": "static", "samples": 4}}))
    opened = open_result(save_result(result, tmp_path / "result.json.gz"))
    assert opened.scene == result.scene
    for side, stress in result.stresses["interface"].items():
        found = opened.stresses["interface"][side]
        assert found.oscillation == stress.oscillation
        assert (found.min, found.max) == (stress.sigma_n.min(), stress.sigma_n.max())
        np.testing.assert_array_equal(found.arc, stress.arc)
        np.testing.assert_array_equal(found.sigma_n_along, stress.sigma_n_along)


def test_any_record_is_read_as_it_was_written(tmp_path):
    data = {"numbers": [1, 2.5, inf, -inf, None], "words": {"a": "b"}}
    made = record("count", data, inputs={"n": 3}, seconds=1.5, warnings=[{"kind": "few"}])
    assert read_record(write_record(made, tmp_path / "r.json")) == made
    assert {"python", "petsc", "numpy"} <= set(made["versions"])
    assert (made["command"], made["commit"]) == ("count", commit())
    with pytest.raises(InputError, match="a stored result"):
        open_result(tmp_path / "r.json")


@pytest.mark.parametrize(
    ("name", "content"),
    [("r.json", None), ("r.json", b"{"), ("r.json", b"{}"), ("r.json.gz", b"\x1f\x8b broken")],
)
def test_what_is_no_record_is_refused(content, name, tmp_path):
    file = tmp_path / name
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match=r"file = .*a stored result"):
        open_result(file)


# Folders of results: refused before the work, replaced as a whole, nobody's own files lost.


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
    own = {"notes.txt": "mine", "mode_2.png": "painted", "modes/own.vtu": "mine too"}
    for name, text in own.items():
        (tmp_path / name).write_text(text)
    assert fill(tmp_path, {"mode_2.png": "c"}) == ["mode_2.png.kept1"]
    kept = {"notes.txt": "mine", "mode_2.png.kept1": "painted"}
    assert content(tmp_path) == kept | {"modes/own.vtu": "mine too", "mode_2.png": "c"}
    assert fill(tmp_path, {"modes": "a file"}) == ["modes.kept1"]
    assert content(tmp_path) == kept | {"modes.kept1/own.vtu": "mine too", "modes": "a file"}


def test_a_list_names_no_files_outside_its_folder(tmp_path):
    out, victim = tmp_path / "out", tmp_path / "victim"
    fill(out, {})
    victim.write_text("")
    (out / MANIFEST).write_text(json.dumps({"files": ["../victim", str(victim), "a/../../victim"]}))
    fill(out, {})
    assert victim.exists()


def test_what_fails_leaves_the_earlier_result(tmp_path):
    fill(tmp_path, {"mode_1.png": "a"})
    before = {file: file.read_bytes() for file in tmp_path.rglob("*")}
    with pytest.raises(TypeError, match="must be str"):
        fill(tmp_path, {"mode_1.png": "half", "mode_2.png": b"no text"})
    assert {file: file.read_bytes() for file in tmp_path.rglob("*")} == before


def test_folders_that_cannot_take_a_result_are_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    for out in (file, file / "inside", file / "inside" / "deeper", tmp_path / ("x" * 300)):
        with pytest.raises(InputError, match=r"out = .*a folder to write to"):
            check_out(out)
    for content_of_it in ("mine", "{}", '{"command": "run"}'):
        (tmp_path / RESULT).write_text(content_of_it)
        with pytest.raises(InputError, match=r"out = .*a folder without a result\.json"):
            check_out(tmp_path)
    assert file.read_text() == "mine"
