"""Bodies from mesh files in scenes: the eigenvalues of the built-in shapes, beside any others."""

from functools import cache

import numpy as np
import pytest
from covering import covering
from file_scenes import built, eigenvalues, from_file

from scenes import run_modes
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene

FILES = ("a.msh", "a.inp", "a.cdb", "a.bdf", "a.xdmf", "a.vtu")
NEEDED = {"cdb": "mapdl_archive", "xdmf": "h5py", "vtu": "meshio"}
KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]


@cache
def expected(cell, degree):
    return eigenvalues(built(cell, degree))


@cache
def frictionless(cell, degree):
    return eigenvalues(built(cell, degree).change("contacts.interface.mu", 0.0))


@pytest.mark.parametrize(("name", "kind"), covering(FILES, KINDS, strength=1))
def test_a_pair_written_and_read_has_the_eigenvalues_it_had(tmp_path, name, kind):
    cell, degree = kind
    if (ending := name.split(".")[1]) in NEEDED:
        pytest.importorskip(NEEDED[ending])
    lacking = ending in ("inp", "cdb", "bdf")
    scene = read_scene(from_file(built(cell, degree), tmp_path / name, lacking))
    found, reference = eigenvalues(scene), expected(cell, degree)
    assert len(found) == len(reference) >= 2
    assert np.abs(found - reference).max() < 1e-10 * np.abs(reference).max()
    without = frictionless(cell, degree)[: len(reference)]
    assert np.abs(np.abs(reference[: len(without)]) - np.abs(without)).max() > 1e-6  # friction acts


def test_a_body_of_a_file_touches_built_in_ones_of_either_backend(tmp_path, backend):
    scene = built("hexahedron", 2)
    data = from_file(scene, tmp_path / "upper.inp", lacking=True, bodies=("upper",))
    data["bodies"]["lower"]["backend"] = backend
    data["bodies"]["lower"]["mesh"]["iga"] = {"degree": [2, 2, 2], "elements": [4, 2, 2]}
    found, beside = eigenvalues(read_scene(data)), expected("hexahedron", 2)
    tolerance = {"fe": 1e-10, "iga": 0.02}[backend]
    assert np.abs(found - beside).max() < tolerance * np.abs(beside).max()


SCENE = """
name = "cube"
[bodies.cube]
backend = "fe"
geometry = { shape = "mesh_file", file = "cube.inp", unit = "mm", part = "upper" }
material = { E = 1.0, nu = 0.3, rho = 1.0 }
supports = [{ surface = "upper_y_max" }]
[analysis]
kind = "cea"
max_frequency = 500.0
"""


@pytest.fixture
def scene_file(tmp_path):
    from_file(built("hexahedron", 1), tmp_path / "cube.inp", bodies=("upper",))
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path / "scene.toml"


def test_files_lie_beside_the_scene_and_sets_are_surfaces(scene_file, monkeypatch):
    monkeypatch.chdir("/")
    scene = load_scene(scene_file)
    geometry = scene.bodies["cube"].geometry
    assert geometry.extent == ((0.0, 2e-3), (0.0, 0.5e-3), (0.0, 2e-3))
    assert "upper_x_min" in geometry.surfaces
    assert len(run_modes(scene).modes) > 2


@pytest.mark.parametrize(
    ("setting", "field", "words"),
    [
        ("geometry.file='none.inp'", "geometry.file", "a mesh file"),
        ("geometry.unit='furlong'", "geometry.unit", "'m', 'cm'"),
        ("geometry.part='pad'", "geometry.part", "a set of elements"),
        ("geometry.merge_nodes=-1.0", "geometry.merge_nodes", "positive"),
        ("mesh.fe={cell = 'tetrahedron', size = 1.0}", "mesh.fe", "those of the file"),
        ("geometry.faces={rim = 3}", "geometry.faces.rim", "a valid array"),
        ("geometry.faces={rim = ['upper_x_min', 'x']}", "geometry.faces", "{'rim': 'x'}"),
        ("geometry.faces={rim = []}", "geometry.faces", "one set of the file or more"),
        ("mesh.degree=9", "mesh.degree", "less than or equal to 4"),
        ("supports.0.surface='z'", "supports.0.surface", "one of upper"),
        ("rotation={axis = [0.0, 0.0, 1.0], rate = 1.0}", "geometry.shape", "to rotate"),
        ("backend='iga'", "backend", "'fe' for shape = 'mesh_file'"),
    ],
)
def test_what_is_refused_of_a_scene(scene_file, setting, field, words):
    with pytest.raises(SceneError) as refused:
        load_scene(scene_file, [f"bodies.cube.{setting}"])
    faults = {fault.field: str(fault) for fault in refused.value.faults}
    assert words in faults[f"bodies.cube.{field}"]
