"""What is known of a run before it: faults, what it leaves out, the memory that it takes."""

import json
import subprocess
import sys

import numpy as np
import pytest
from bad_inputs import BUILT, changed, coarse
from blocks import GPTS, two_blocks
from blocks import coarse as of_few_elements
from PIL import Image

from cea.eigen import mumps
from cea.errors import InputError
from scenes import assemble, inspect_scene, load_scene, read_scene, run_modes, run_scene, run_static
from scenes.checking import memory
from scenes.checking.skipped import GIVEN, skipped_by
from scenes.results.pictures import draw_scene


def scene_of(base, backend, *changes):
    return read_scene(changed(coarse(base, backend, BUILT), changes))


def test_what_is_seen_before_is_what_a_run_has(backend):
    scene = scene_of("blocks", backend, "contacts.interface.full_pass=true")
    looked, result = inspect_scene(scene), run_modes(scene)
    assert not looked.faults
    assert looked.dofs == result.system.size
    assert looked.halves.keys() == result.interfaces.keys()
    for name, half in looked.halves.items():
        assert len(half.interface.points) == len(result.interfaces[name].points)
    assert looked.skipped == result.skipped
    assert {w.kind for w in looked.warnings} <= {w.kind for w in result.warnings}


def test_every_contact_with_a_fault_is_told(backend):
    mortar = {"P": 1e9, "formulation": {"method": "mortar"}}
    scene = load_scene("disc_pad", backend=backend).change(
        {
            "contacts.second": mortar | {"a": "pad.outer", "b": "disc.bottom"},
            "contacts.third": mortar | {"a": "pad.inner", "b": "disc.outer"},
        }
    )
    looked = inspect_scene(scene)
    assert [fault.field for fault in looked.faults] == ["contacts.second", "contacts.third"]
    assert list(looked.halves) == ["pad_disc"]


def test_modes_and_modal_damping_need_a_free_degree_of_freedom():
    """A body without one is an obstacle for others; forces at its supports need none either."""
    held = {
        "mesh": {"fe": {"cell": "quadrilateral", "degree": 1, "elements": [1, 1]}},
        "supports": [{"surface": "x_min"}, {"surface": "x_max"}],
    }
    obstacle = load_scene("blocks", backend="fe").change(
        {f"bodies.upper.{field}": value for field, value in held.items()}
    )
    assert len(run_modes(obstacle).modes) > 0
    modal = {"modal": {"ratio": 0.01, "max_frequency": 1.0}}
    for scene in (
        obstacle.change("bodies.upper.damping", modal),
        obstacle.change({f"bodies.lower.{field}": value for field, value in held.items()}),
    ):
        with pytest.raises(InputError, match="they hold all of them") as refused:
            run_modes(scene)
        assert refused.value.field == "bodies.upper.supports"
        assert [str(fault) for fault in inspect_scene(scene).faults] == [str(refused.value)]
    static = scene.change("analysis", {"kind": "static"})
    assert run_static(static).system.size == 0


@pytest.mark.parametrize(
    ("backend", "base"),
    [("fe", "disc_pad"), pytest.param("iga", "blocks", marks=pytest.mark.slow)],
)
def test_the_picture_shows_bodies_supports_and_contacts(backend, base, tmp_path):
    file = draw_scene(inspect_scene(scene_of(base, backend)), tmp_path / "scene.png")
    image = np.asarray(Image.open(file).convert("RGB")).astype(int)
    dark_blue = (image[..., 2] - image[..., 0] > 15) & (image[..., 0] < 110)
    red = (image[..., 0] > 120) & (image[..., 1] < 90) & (image[..., 2] < 90)
    assert (image < 240).any(axis=2).mean() > 0.1
    assert dark_blue.sum() > 300
    assert red.sum() > 300


# What a scene does not need is neither computed nor imported, and the result says so.
LOAD = {"surface": "upper.x_min", "pressure": 1.0}


def test_without_friction_no_slip_operator_and_the_symmetric_path(backend):
    for mu in (0.0, 0.4):
        data = of_few_elements(two_blocks(backend, GPTS, held=True, mu=mu))
        result = run_scene(read_scene(data))
        (contact,) = result.system.contacts
        assert (contact.slip is None) == (contact.K_f is None) == (mu == 0.0)
        assert ("friction" in result.skipped) == (mu == 0.0)
        assert (result.modes.window.symmetric_count is not None) == (mu == 0.0)


EVERY_RUN = {"newton", "damping", "gyroscopic", "loads", "pictures", "paraview", "gmsh"}
EVERY_RUN.add("doubts of units")
STATIC = EVERY_RUN - {"damping", "gyroscopic", "loads"} | {"mass", "eigenvalues"}
SLIDING = {"speed": 2.0, "pressure": 1.0}


@pytest.mark.parametrize(
    ("changes", "skipped", "unused"),
    [
        ({}, EVERY_RUN, set()),
        ({"contacts": {}}, EVERY_RUN | {"friction", "search"}, set()),
        ({"loads": [LOAD], "analysis": {"kind": "static"}}, STATIC, set()),
        ({"analysis.min_growth": -1.0}, None, {"analysis.min_growth"}),
        (
            {"contacts.interface.mu": 0.0, "contacts.interface.sliding": SLIDING},
            None,
            {"contacts.interface.sliding.speed"},
        ),
    ],
)
def test_a_scene_tells_exactly_what_it_does_not_need(backend, changes, skipped, unused):
    """And what is given without use, with its path."""
    found = skipped_by(read_scene(two_blocks(backend, GPTS)).change(changes))
    given = {name for name, reason in found.items() if reason.startswith(GIVEN)}
    other = {"fe": "iga", "iga": "fe"}[backend]
    assert given == unused | {f"bodies.*.mesh.{other}"}
    if skipped is not None:
        assert set(found) - given == skipped


UNUSED = {
    "meshes.files.reading",
    "scenes.matrices",
    "scenes.export",
    "scenes.results.pictures",
    "pyvista",
}
"""What modes of a disc and a pad at a given stiffness have no use for."""
PROGRAM = """
import sys; sys.argv = ['cea', 'run', 'disc_pad', *sys.argv[1:]]
from comparisons.cli.app import app
app(standalone_mode=False)
print('imported', *sys.modules)
"""


@pytest.mark.parametrize("backend", ["iga", pytest.param("fe", marks=pytest.mark.slow)])
def test_a_run_loads_what_it_needs_and_writes_a_complete_result(backend, tmp_path):
    arguments = ["--backend", backend, "--out", str(tmp_path)]
    for body, elements in (("disc", [3, 12, 1]), ("pad", [2, 3, 1])):
        arguments += ["--set", f"bodies.{body}.mesh.{backend}.elements={elements}"]
    command = [sys.executable, "-c", PROGRAM, *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    imported = set(done.stdout.split("imported", 1)[1].split())
    assert not UNUSED & imported
    assert ("fe_cea" in imported) == (backend == "fe")
    assert ("iga_cea" in imported) == (backend == "iga")
    result = json.loads((tmp_path / "result.json").read_text())
    assert [result["scene"]["bodies"][name]["backend"] for name in ("disc", "pad")] == 2 * [backend]
    assert result["dofs"]["free"] > result["dofs"]["bodies"]["pad"] > 0
    assert {"meshing", "assembly", "factorisation", "krylov"} <= set(result["timings"])
    assert "newton" in result["skipped"]
    assert all(set(pair) >= {"re", "im", "residual"} for pair in result["eigenvalues"])


# Scenes that cannot fit into memory are refused, or go to disk.
def test_a_huge_mesh_is_refused_at_once():
    scene = load_scene("blocks", ["bodies.upper.mesh.iga.elements=[100000,100000]"], "iga")
    with pytest.raises(InputError, match=r"dofs need at least .* GB, and .* GB are free") as caught:
        run_modes(scene)
    assert caught.value.field == "bodies.upper.mesh.iga.elements"


FINE = {
    f"bodies.{body}.mesh": {
        "fe": {"cell": "quadrilateral", "elements": [32, 16]},
        "iga": {"degree": [2, 2], "elements": [64, 32]},
    }
    for body in ("upper", "lower")
}


@pytest.mark.grid(quick=1)
def test_factors_go_to_disk_where_memory_would_not_do(backend, monkeypatch):
    """Of a fresh run, and at every value of a scene that is assembled once."""
    scene = load_scene("blocks", backend=backend).change(FINE | {"analysis.max_frequency": 0.3})
    plain = run_modes(scene)
    assert "factors-on-disk" not in [warning.kind for warning in plain.warnings]
    monkeypatch.setattr(mumps, "free_memory", lambda comm: 1e6)
    with pytest.raises(InputError, match=r"take .* of memory, .* with factors on disk") as caught:
        run_modes(scene)
    assert caught.value.field == f"bodies.upper.mesh.{backend}.elements"
    lack = caught.value.__cause__
    assert lack.with_files < lack.memory
    monkeypatch.setattr(mumps, "free_memory", lambda comm: 0.5 * (lack.memory + lack.with_files))
    assembled = assemble(scene)
    for result in (run_modes(scene), assembled.modes()):
        (disk,) = [warning for warning in result.warnings if warning.kind == "factors-on-disk"]
        assert disk.data["memory_with_files"] < disk.data["available"] < disk.data["memory"]
        np.testing.assert_allclose(result.eigenvalues, plain.eigenvalues, rtol=1e-9, atol=1e-9)
    assembled.free()
    monkeypatch.setattr(memory, "free_disk", lambda: 0.5 * lack.files)
    with pytest.raises(InputError, match=r"GB of factors do not fit on the disk, .* GB free"):
        run_modes(scene)


def test_a_static_analysis_without_room_for_factors_is_refused_by_its_mesh(backend, monkeypatch):
    """Its factors are in memory, whatever room there is on disk."""
    scene = load_scene("patch_test", backend=backend)
    monkeypatch.setattr(mumps, "free_memory", lambda comm: 1e6)
    with pytest.raises(InputError, match="a mesh that fits into memory") as caught:
        run_static(scene)
    assert caught.value.field.endswith(f"mesh.{backend}.elements")
