"""What a scene does not need is neither computed nor imported, and the result says so."""

import subprocess
import sys

import mixed_brake
import pytest
from blocks import two_blocks

import cea.eigen.driver
from comparisons.cli.output import print_skipped
from scenes import run_scene
from scenes.checking.skipped import GIVEN, skipped_by
from scenes.spec.reading import read_scene

GPTS = {"method": "gpts", "points": 3}
LOAD = {"surface": "upper.x_min", "pressure": 1.0}


@pytest.fixture
def taken(monkeypatch):
    """Whether each search that is made takes the symmetric path."""
    paths = []
    original = cea.eigen.driver.UndampedSearch

    def recorded(matrices, *arguments, **options):
        paths.append(matrices.symmetric)
        return original(matrices, *arguments, **options)

    monkeypatch.setattr(cea.eigen.driver, "UndampedSearch", recorded)
    return paths


def test_without_friction_no_slip_operator_and_the_symmetric_path(backend, taken):
    results = {
        mu: run_scene(read_scene(two_blocks(backend, GPTS, held=True, mu=mu))) for mu in (0.0, 0.4)
    }
    assert taken == [True, False]
    assert results[0.0].system.contacts[0].slip is None
    assert results[0.0].system.contacts[0].K_f is None
    assert results[0.4].system.contacts[0].slip is not None
    assert "friction" in results[0.0].skipped
    assert "friction" not in results[0.4].skipped


EVERY_RUN = {
    "newton",
    "damping",
    "gyroscopic",
    "loads",
    "pictures",
    "paraview",
    "gmsh",
    "doubts of units",
}
TETRAHEDRA = {"cell": "tetrahedron", "size": 0.2}


@pytest.mark.parametrize(
    ("backend", "changes", "expected"),
    [
        ("iga", {}, EVERY_RUN),
        ("fe", {"bodies.upper.mesh.fe": TETRAHEDRA}, EVERY_RUN - {"gmsh"}),
        ("fe", {"contacts": {}}, EVERY_RUN | {"friction", "search"}),
        ("fe", {"output": {"pictures": 1, "paraview": 1}}, EVERY_RUN - {"pictures", "paraview"}),
        (
            "fe",
            {"analysis": {"kind": "static"}, "loads": [LOAD]},
            EVERY_RUN - {"damping", "gyroscopic", "loads"} | {"mass", "eigenvalues"},
        ),
    ],
)
def test_a_scene_tells_exactly_what_it_does_not_need(backend, changes, expected):
    scene = read_scene(two_blocks(backend, GPTS)).change(changes)
    skipped = skipped_by(scene)
    given = {name for name, reason in skipped.items() if reason.startswith(GIVEN)}
    assert set(skipped) - given == expected - given
    assert all(name not in expected or name == "loads" for name in given)


FRICTION = "contacts.interface.friction_direction_on_a"
DIRECTION = {"speed": 2.0, "pressure": 1.0}


@pytest.mark.parametrize("backend", ["fe", "iga"])
@pytest.mark.parametrize(
    ("changes", "unused"),
    [
        ({}, set()),
        ({"loads": [LOAD]}, {"loads"}),
        ({"loads": [LOAD], "analysis": {"kind": "static"}}, set()),
        ({"analysis.min_growth": -1.0}, {"analysis.min_growth"}),
        ({"analysis.min_growth": -1.0, "bodies.upper.damping": {"alpha": 0.1}}, set()),
        ({"contacts.interface.mu": 0.0}, {FRICTION}),
        (
            {"contacts.interface.mu": 0.0, "contacts.interface.sliding": DIRECTION},
            {"contacts.interface.sliding.speed"},
        ),
    ],
)
def test_what_is_given_without_use_is_told_with_its_path(backend, changes, unused):
    scene = read_scene(two_blocks(backend, GPTS)).change(changes)
    other = "iga" if backend == "fe" else "fe"
    found = {name for name, why in skipped_by(scene).items() if why.startswith(GIVEN)}
    assert found == unused | {f"bodies.*.mesh.{other}"}


def test_elements_that_are_changed_on_reading_are_not_called_left_out(tmp_path, capsys):
    file = tmp_path / "brake.inp"
    file.write_text(mixed_brake.brake(0.03))
    skipped = skipped_by(read_scene(mixed_brake.scene(file, friction=0.5)))
    for explain in (False, True):
        print_skipped(skipped, explain=explain)
        told = [line for line in capsys.readouterr().out.splitlines() if "mixed elements" in line]
        assert len(told) == 1
        assert "changed on reading: " in told[0]
        assert "left out" not in told[0]


UNUSED = (
    "meshes.files.reading",
    "meshes.files.part",
    "scenes.matrices",
    "scenes.spec.matrices",
    "cea.eigen.static",
    "cea.system.steady_path",
    "cea.system.steady_newton",
    "cea.system.modal_damping",
    "scenes.running.static",
    "scenes.checking.equilibrium",
    "scenes.export",
    "scenes.pictures",
    "scenes.refinement",
    "gmsh",
    "pyvista",
)
"""What modes of a disc and a pad at a given stiffness have no use for."""
MOST = {"fe": 144, "iga": 150}
"""Modules of this program that they load, at most."""
COARSE = {
    f"bodies.{body}.mesh.{backend}.elements": elements
    for backend in ("fe", "iga")
    for body, elements in (("disc", [3, 12, 1]), ("pad", [2, 3, 1]))
}


@pytest.mark.parametrize("backend", ["iga", pytest.param("fe", marks=pytest.mark.slow)])
def test_a_run_loads_what_it_needs(backend, tmp_path):
    settings = [part for name, value in COARSE.items() for part in ("--set", f"{name}={value}")]
    code = (
        "import sys; sys.argv = ['cea', 'run', 'disc_pad', *sys.argv[1:]]\n"
        "from comparisons.cli.app import app\n"
        "app(standalone_mode=False)\n"
        "print('imported', *sys.modules)"
    )
    command = [sys.executable, "-c", code, "--backend", backend, "--out", str(tmp_path), *settings]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    imported = set(done.stdout.split("imported", 1)[1].split())
    packages = ("cea", "fe_cea", "iga_cea", "meshes", "scenes", "comparisons", "exact_cea")
    own = [name for name in imported if name.partition(".")[0] in packages]
    assert not set(UNUSED) & imported
    assert ("fe_cea" in imported) == (backend == "fe")
    assert ("iga_cea" in imported) == (backend == "iga")
    assert len(own) <= MOST[backend]
