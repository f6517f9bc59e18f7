"""Memory is estimated before work starts: scenes that cannot fit are refused, or go to disk."""

import sys

import mixed_brake
import numpy as np
import pytest
from mpi import run
from peak_memory import PEAK

from cea.errors import InputError
from scenes import assemble, load_scene, read_scene, run_modes
from scenes.checking import memory
from scenes.checking.memory import estimated_memory

DISC = "bodies.disc.mesh"


@pytest.mark.parametrize(
    ("name", "setting"),
    [
        ("blocks", "bodies.upper.mesh.iga.elements=[100000,100000]"),
        ("disc_pad", f"{DISC}.fe.elements=[400,400,400]"),
        ("disc_pad", f"{DISC}.fe={{cell='tetrahedron',size=1e-5}}"),
    ],
)
def test_huge_meshes_are_refused_at_once(name, setting):
    scene = load_scene(name, [setting], "fe" if "fe" in setting else "iga")
    with pytest.raises(InputError, match=r"dofs take about .* GB of the .* GB") as caught:
        run_modes(scene)
    assert caught.value.field.startswith(setting.partition("=")[0])


def test_dofs_are_those_of_the_run(backend):
    """Supported dofs are counted too: at most a few per cent on such a mesh."""
    scene = load_scene("drum", backend=backend)
    size = run_modes(scene).system.size
    assert size < estimated_memory(scene).dofs < 1.15 * size


@pytest.mark.parametrize("degree", [2, 3])
def test_dofs_of_mixed_elements(tmp_path, degree):
    """They are divided into tetrahedra, which have a sixth of the nodes of hexahedra."""
    file = tmp_path / "brake.inp"
    file.write_text(mixed_brake.brake(0.02))
    given = mixed_brake.scene(file, friction=0.5)
    for body in given["bodies"].values():
        body["mesh"] = {"degree": degree}
    scene = read_scene(given)
    assert estimated_memory(scene).dofs == pytest.approx(run_modes(scene).system.size, rel=0.3)


def test_factors_go_to_disk_where_memory_would_not_do(backend, monkeypatch):
    """Of a fresh run, and at every value of a scene that is assembled once."""
    scene = load_scene("blocks", backend=backend)
    plain, estimate = run_modes(scene), estimated_memory(scene)
    assert "factors-on-disk" not in [warning.kind for warning in plain.warnings]
    room = 0.5 * (estimate.bytes + estimate.bytes_with_files) / 0.9
    monkeypatch.setattr(memory, "available_memory", lambda: room)
    assembled = assemble(scene)
    for result in (run_modes(scene), assembled.modes(), assembled.modes()):
        (told,) = [warning for warning in result.warnings if warning.kind == "factors-on-disk"]
        assert told.data["memory_with_files"] < told.data["available"] < told.data["memory"]
        np.testing.assert_allclose(result.eigenvalues, plain.eigenvalues, rtol=1e-9, atol=1e-9)
    assembled.free()
    monkeypatch.setattr(memory, "free_disk", lambda: 0.5 * estimate.factors)
    with pytest.raises(InputError, match=r"GB of factors on disk, where .* GB are free"):
        run_modes(scene)


PEAK_OF_A_RUN = f"""{PEAK}
import sys
from scenes import load_scene, run_scene
run_scene(load_scene(sys.argv[1], sys.argv[2:]))
print(peak())
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    [
        ["disc_pad"],
        ["disc_pad", "bodies.disc.backend=fe", "bodies.pad.backend=fe"],
        ["blocks", "bodies.upper.mesh.iga.elements=[240,60]"],
        ["disc_pad", f"{DISC}.iga.elements=[12,60,2]", "bodies.disc.damping={alpha=5.0}"],
        ["patch_test", "bodies.upper.mesh.iga.elements=[9,9,9]"],
    ],
)
def test_the_estimate_is_near_the_peak_of_a_run(scene):
    done = run(sys.executable, "-c", PEAK_OF_A_RUN, *scene)
    assert done.returncode == 0, done.stderr
    peak = float(done.stdout)
    assert 0.6 < estimated_memory(load_scene(scene[0], scene[1:])).bytes / peak < 2.0
