"""Memory is estimated before work starts: scenes that cannot fit are refused, or go to disk."""

import mixed_brake
import numpy as np
import pytest

from cea.eigen import mumps
from cea.errors import InputError
from scenes import assemble, run_modes, run_static
from scenes.checking import memory
from scenes.checking.memory import dofs_of
from scenes.spec.reading import load_scene, read_scene


@pytest.mark.parametrize(
    "overrides",
    [
        ["blocks", "bodies.upper.mesh.iga.elements=[100000,100000]"],
        ["disc_pad", "bodies.disc.backend=fe", "bodies.disc.mesh.fe.elements=[400,400,400]"],
        [
            "disc_pad",
            "bodies.disc.backend=fe",
            "bodies.disc.mesh.fe={cell='tetrahedron',size=1e-5}",
        ],
    ],
)
def test_huge_meshes_are_refused_at_once(overrides):
    name, *settings = overrides
    scene = load_scene(name, settings)
    with pytest.raises(InputError, match=r"dofs take .* GB or more of the .* GB") as caught:
        run_modes(scene)
    assert caught.value.field.startswith(settings[-1].partition("=")[0])


def test_dofs_are_those_of_the_run(backend):
    """Supported dofs are counted too: at most a few per cent on such a mesh."""
    scene = load_scene("drum", backend=backend)
    size = run_modes(scene).system.size
    assert size < sum(map(dofs_of, scene.bodies.values())) < 1.15 * size


@pytest.mark.parametrize("degree", [2, 3])
def test_dofs_of_mixed_elements(tmp_path, degree):
    """They are divided into tetrahedra, which have a sixth of the nodes of hexahedra."""
    file = tmp_path / "brake.inp"
    file.write_text(mixed_brake.brake(0.02))
    given = mixed_brake.scene(file, friction=0.5)
    for body in given["bodies"].values():
        body["mesh"] = {"degree": degree}
    scene = read_scene(given)
    dofs = sum(map(dofs_of, scene.bodies.values()))
    assert dofs == pytest.approx(run_modes(scene).system.size, rel=0.3)


FINE = [
    f"bodies.{body}.mesh={{fe={{cell='quadrilateral',elements=[48,24]}},"
    "iga={degree=[2,2],elements=[96,48]}}"
    for body in ("upper", "lower")
]


def test_factors_go_to_disk_where_memory_would_not_do(backend, monkeypatch):
    """Of a fresh run, and at every value of a scene that is assembled once."""
    scene = load_scene("blocks", [*FINE, "analysis.max_frequency=0.5"], backend)
    plain = run_modes(scene)
    assert "factors-on-disk" not in [warning.kind for warning in plain.warnings]
    monkeypatch.setattr(mumps, "free_memory", lambda comm: 1e6)
    with pytest.raises(InputError, match=r"take .* of memory, .* with those on disk") as caught:
        run_modes(scene)
    assert caught.value.field == f"bodies.upper.mesh.{backend}.elements"
    lack = caught.value.__cause__
    assert lack.with_files < lack.memory
    monkeypatch.setattr(mumps, "free_memory", lambda comm: 0.5 * (lack.memory + lack.with_files))
    assembled = assemble(scene)
    for result in (run_modes(scene), assembled.modes(), assembled.modes()):
        (told,) = [warning for warning in result.warnings if warning.kind == "factors-on-disk"]
        assert told.data["memory_with_files"] < told.data["available"] < told.data["memory"]
        np.testing.assert_allclose(result.eigenvalues, plain.eigenvalues, rtol=1e-9, atol=1e-9)
    assembled.free()
    monkeypatch.setattr(memory, "free_disk", lambda: 0.5 * lack.files)
    with pytest.raises(InputError, match=r"GB of factors on disk, where .* GB are free"):
        run_modes(scene)


def test_a_static_analysis_without_room_for_factors_is_refused_by_its_mesh(backend, monkeypatch):
    """Its factors are in memory, whatever room there is on disk."""
    scene = load_scene("patch_test", backend=backend)
    monkeypatch.setattr(mumps, "free_memory", lambda comm: 1e6)
    with pytest.raises(InputError, match="a mesh that fits into memory") as caught:
        run_static(scene)
    assert caught.value.field.endswith(f"mesh.{backend}.elements")
