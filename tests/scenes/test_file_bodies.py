"""Bodies from mesh files in scenes: as built-in shapes, beside any others, beside CalculiX."""

import subprocess
from functools import cache

import numpy as np
import pytest
from covering import covering
from decks import with_calculix
from file_scenes import built, eigenvalues, from_file
from mixed_brake import MATERIALS, brake, scene
from mpi import cea_on_ranks

from scenes import SceneError, load_scene, open_result, read_scene, run_modes
from scenes.spec.plain import scene_text

pytestmark = pytest.mark.usefixtures("files_read_here")
KINDS = [("hexahedron", 1), ("hexahedron", 2), ("tetrahedron", 1), ("tetrahedron", 2)]


@cache
def expected(cell, degree, mu=1.5):
    return eigenvalues(built(cell, degree).change("contacts.interface.mu", mu))


@pytest.mark.parametrize(("ending", "kind"), covering(("msh", "inp", "bdf"), KINDS, strength=1))
def test_a_pair_written_and_read_has_the_eigenvalues_it_had(tmp_path, ending, kind):
    lacking = ending != "msh"
    data = from_file(built(*kind), tmp_path / f"a.{ending}", lacking)
    found, reference = eigenvalues(read_scene(data)), expected(*kind)
    assert len(found) == len(reference) >= 2
    assert np.abs(found - reference).max() < 1e-10 * np.abs(reference).max()
    without = expected(*kind, mu=0.0)[: len(reference)]
    assert np.abs(np.abs(reference[: len(without)]) - np.abs(without)).max() > 1e-6  # friction acts


def test_a_body_of_a_file_touches_built_in_ones_of_either_backend(tmp_path, backend):
    file = tmp_path / "upper.inp"
    data = from_file(built("hexahedron", 2), file, lacking=True, bodies=("upper",))
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
    found = load_scene(scene_file)
    geometry = found.bodies["cube"].geometry
    assert geometry.extent == ((0.0, 2e-3), (0.0, 0.5e-3), (0.0, 2e-3))
    assert "upper_x_min" in geometry.surfaces
    assert len(run_modes(found).modes) > 2


def test_lengths_of_a_file_are_taken_as_they_are_in_other_units(scene_file):
    """A body in mm, t, s has the frequencies (Hz) of the same body in SI units."""
    expected = run_modes(load_scene(scene_file)).frequencies
    other = ["units='other'", "bodies.cube.material={E=1e-6, nu=0.3, rho=1e-12}"]
    with pytest.raises(SceneError, match=r"geometry.unit = 'mm': left out where units = 'other'"):
        load_scene(scene_file, other)
    scene_file.write_text(SCENE.replace('unit = "mm", ', ""))
    found = run_modes(load_scene(scene_file, other)).frequencies
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    with pytest.raises(SceneError, match=r"geometry.unit = None: the unit of length"):
        load_scene(scene_file)


@pytest.mark.parametrize(
    ("setting", "field", "words"),
    [
        ("geometry.file='none.inp'", "geometry.file", "a mesh file"),
        ("geometry.part='pad'", "geometry.part", "a set of elements"),
        ("mesh.fe={cell = 'tetrahedron', size = 1.0}", "mesh.fe", "those of the file"),
        ("geometry.faces={rim = ['upper_x_min', 'x']}", "geometry.faces", "{'rim': 'x'}"),
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


# A brake whose disc has wedges at its hub: bonded beside CalculiX, sliding on several ranks.
COUNT = 20


def job(size):
    """The deck of the same for CalculiX, held at the bore and behind."""
    lines = []
    for part, (E, nu, rho) in MATERIALS.items():
        lines += [f"*MATERIAL, NAME={part}", "*ELASTIC", f"{E}, {nu}", "*DENSITY", f"{rho}"]
        lines += [f"*SOLID SECTION, ELSET={part}, MATERIAL={part}"]
    lines += ["*BOUNDARY", "BORE, 1, 3", "BACK, 1, 3"]
    lines += ["*STEP", "*FREQUENCY, STORAGE=YES", f"{COUNT}", "*END STEP"]
    return brake(size, shared=True) + "\n".join(lines) + "\n"


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.008, 0.005])
def test_a_bonded_brake_has_the_frequencies_of_calculix(tmp_path, size):
    with_calculix()
    (tmp_path / "job.inp").write_text(job(size))
    subprocess.run(["ccx", "-i", "job"], cwd=tmp_path, capture_output=True, check=True)
    rows = [line.split() for line in (tmp_path / "job.dat").read_text().splitlines()]
    theirs = np.array([float(row[3]) for row in rows if len(row) == 5 and row[0].isdecimal()])
    assert len(theirs) >= COUNT
    file = tmp_path / "brake.inp"
    file.write_text(brake(size))
    result = run_modes(read_scene(scene(file)))
    assert "mixed elements" in result.skipped
    ours = np.sort(result.modes.frequencies)[:COUNT]
    assert np.abs(ours / theirs[:COUNT] - 1).max() < 0.01


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_bodies_from_a_file_are_the_same_on_several_ranks(tmp_path, ranks):
    deck, file, found = tmp_path / "brake.inp", tmp_path / "brake.toml", []
    deck.write_text(brake(0.03))
    file.write_text(scene_text(read_scene(scene(deck, friction=0.6, top=9000.0))))
    for count in (1, ranks):
        done = cea_on_ranks(count, "run", file, "--out", tmp_path / str(count))
        assert done.returncode == 0, done.stderr
        found.append(open_result(tmp_path / str(count) / "result.json").eigenvalues)
    assert len(found[0]) > 6
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-9 * np.abs(found[0]).max())
