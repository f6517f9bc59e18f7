"""What a scene does not need is neither computed nor imported, and the result says so."""

import subprocess
import sys

import mixed_brake
import pytest
from blocks import two_blocks

import cea.eigen.driver
from comparisons.cli.output import print_skipped
from scenes import read_scene, run_scene
from scenes.checking.skipped import GIVEN, skipped_by

GPTS = {"method": "gpts", "points": 3}
LOAD = {"surface": "upper.x_min", "pressure": 1.0}


def test_without_friction_no_slip_operator_and_the_symmetric_path(backend, monkeypatch):
    symmetric, search = [], cea.eigen.driver.UndampedSearch

    def recorded(matrices, *arguments, **options):
        symmetric.append(matrices.symmetric)
        return search(matrices, *arguments, **options)

    monkeypatch.setattr(cea.eigen.driver, "UndampedSearch", recorded)
    for mu in (0.0, 0.4):
        result = run_scene(read_scene(two_blocks(backend, GPTS, held=True, mu=mu)))
        (contact,) = result.system.contacts
        assert (contact.slip is None) == (contact.K_f is None) == (mu == 0.0)
        assert ("friction" in result.skipped) == (mu == 0.0)
    assert symmetric == [True, False]


EVERY_RUN = {"newton", "damping", "gyroscopic", "loads", "pictures", "paraview", "gmsh"}
EVERY_RUN.add("doubts of units")
STATIC = EVERY_RUN - {"damping", "gyroscopic", "loads"} | {"mass", "eigenvalues"}
DIRECTION = "contacts.interface.friction_direction_on_a"
SLIDING = {"speed": 2.0, "pressure": 1.0}


@pytest.mark.parametrize(
    ("changes", "skipped", "unused"),
    [
        ({}, EVERY_RUN, set()),
        (
            {"bodies.upper.mesh.fe": {"cell": "tetrahedron", "size": 0.2}},
            {"fe": EVERY_RUN - {"gmsh"}, "iga": EVERY_RUN},
            set(),
        ),
        ({"contacts": {}}, EVERY_RUN | {"friction", "search"}, set()),
        ({"output": {"pictures": 1, "paraview": 1}}, EVERY_RUN - {"pictures", "paraview"}, set()),
        ({"loads": [LOAD], "analysis": {"kind": "static"}}, STATIC, set()),
        ({"loads": [LOAD]}, None, {"loads"}),
        ({"analysis.min_growth": -1.0}, None, {"analysis.min_growth"}),
        ({"analysis.min_growth": -1.0, "bodies.upper.damping": {"alpha": 0.1}}, None, set()),
        ({"contacts.interface.mu": 0.0}, None, {DIRECTION}),
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
        expected = skipped[backend] if isinstance(skipped, dict) else skipped
        assert set(found) - given == expected


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
    *("meshes.files.reading", "meshes.files.part", "scenes.matrices", "scenes.spec.matrices"),
    *("cea.eigen.static", "cea.system.steady_path", "cea.system.steady_newton"),
    *("cea.system.modal_damping", "scenes.running.static", "scenes.checking.steady"),
    *("scenes.export", "scenes.pictures", "scenes.refinement", "gmsh", "pyvista"),
)
"""What modes of a disc and a pad at a given stiffness have no use for."""
MOST = {"fe": 144, "iga": 150}
"""Modules of this program that they load, at most."""
PROGRAM = """
import sys; sys.argv = ['cea', 'run', 'disc_pad', *sys.argv[1:]]
from comparisons.cli.app import app
app(standalone_mode=False)
print('imported', *sys.modules)
"""


@pytest.mark.parametrize("backend", ["iga", pytest.param("fe", marks=pytest.mark.slow)])
def test_a_run_loads_what_it_needs(backend, tmp_path):
    settings = []
    for body, elements in (("disc", [3, 12, 1]), ("pad", [2, 3, 1])):
        settings += ["--set", f"bodies.{body}.mesh.{backend}.elements={elements}"]
    arguments = ["--backend", backend, "--out", str(tmp_path), *settings]
    command = [sys.executable, "-c", PROGRAM, *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    imported = set(done.stdout.split("imported", 1)[1].split())
    packages = ("cea", "fe_cea", "iga_cea", "meshes", "scenes", "comparisons", "exact_cea")
    own = [name for name in imported if name.partition(".")[0] in packages]
    assert not set(UNUSED) & imported
    assert ("fe_cea" in imported) == (backend == "fe")
    assert ("iga_cea" in imported) == (backend == "iga")
    assert len(own) <= MOST[backend]
