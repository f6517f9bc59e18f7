"""Memory is estimated before work starts: scenes that cannot fit are refused with what would."""

import sys

import pytest
from mpi import run
from peak_memory import PEAK

from cea.errors import InputError
from scenes import run_modes
from scenes.checking import memory
from scenes.checking.memory import available_memory, check_memory, estimated_memory
from scenes.spec.reading import load_scene

PEAK_OF_A_RUN = (
    PEAK
    + """
import sys
from scenes import load_scene, run_scene
run_scene(load_scene(sys.argv[1], sys.argv[2:]))
print(peak())
"""
)


@pytest.mark.parametrize(
    "overrides",
    [
        ["blocks", "bodies.upper.mesh.iga.elements=[100000,100000]"],
        ["disc_pad", "bodies.disc.mesh.iga.elements=[1000,1000,100]"],
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
    with pytest.raises(InputError, match=r"dofs take about .* GB of the .* GB") as caught:
        run_modes(scene)
    field, fault = settings[-1].partition("=")[0], caught.value
    assert fault.field.startswith(field)
    assert "would, the other bodies" in fault.allowed


def test_what_would_fit_fits(monkeypatch):
    scene = load_scene("disc_pad", backend="fe")
    check_memory(scene)
    monkeypatch.setattr(memory, "available_memory", lambda: 6e8)
    with pytest.raises(InputError) as caught:
        check_memory(scene)
    assert caught.value.field == "bodies.disc.mesh.fe.elements"
    coarser = eval(caught.value.allowed.partition("elements = ")[2].partition(" would")[0])
    share = coarser[1] / scene.bodies["disc"].mesh.fe.elements[1]
    coarse, fine = estimated_memory(scene, share), estimated_memory(scene)
    assert coarse.bytes_with_files < 0.9 * 6e8 < fine.bytes_with_files
    monkeypatch.setattr(memory, "available_memory", lambda: 1e8)
    with pytest.raises(InputError, match="none would"):
        check_memory(scene)


def test_dofs_are_those_of_the_run(backend):
    """Supported dofs are counted too: at most a few per cent on such a mesh."""
    scene = load_scene("drum", backend=backend)
    size = run_modes(scene).system.size
    assert size < estimated_memory(scene).dofs < 1.15 * size


def test_estimates_grow_as_factors_do():
    """Entries of the factors grow as n^(4/3) in space, as n log n in the plane."""
    space, plane = load_scene("blocks_3d"), load_scene("blocks")
    for scene, low, high in ((space, 1.25, 1.45), (plane, 1.0, 1.15)):
        few, many = estimated_memory(scene, 64.0), estimated_memory(scene, 128.0)
        ratio = many.dofs / few.dofs
        growth = many.factor_entries / few.factor_entries
        assert ratio**low < growth < ratio**high


def test_modes_that_are_damped_one_by_one_take_memory():
    """A column for each on its body, and in the solutions; none where nothing is damped."""
    plain = load_scene("disc_pad")
    few, many = (
        plain.change("bodies.disc.damping", {"modal": {"ratios": n * [0.01]}}) for n in (10, 110)
    )
    assert estimated_memory(plain).modal == 0
    column = (estimated_memory(many).modal - estimated_memory(few).modal) / 100
    dofs = estimated_memory(plain).dofs
    assert 48 * dofs < column < 56 * dofs
    assert estimated_memory(many).bytes - estimated_memory(few).bytes == pytest.approx(100 * column)
    none = plain.change("bodies.disc.damping", {"alpha": 1.0, "modal": {"ratios": [0.0, 0.0]}})
    assert estimated_memory(none).modal == 0


def test_no_more_is_available_than_the_machine_has():
    assert 1e8 < available_memory() < 1e14


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    [
        ["disc_pad"],
        ["disc_pad", "bodies.disc.backend=fe", "bodies.pad.backend=fe"],
        ["blocks", "bodies.upper.mesh.iga.elements=[240,60]"],
        ["disc_pad", "bodies.disc.mesh.iga.elements=[12,60,2]", "bodies.disc.damping={alpha=5.0}"],
        ["patch_test", "bodies.upper.mesh.iga.elements=[9,9,9]"],
        [
            *("disc_pad", "bodies.disc.mesh.iga.elements=[10,50,2]", "analysis.max_frequency=5e3"),
            "bodies.disc.damping={modal={ratio=0.01, max_frequency=120000.0}}",
        ],
    ],
)
def test_the_estimate_is_near_the_peak_of_a_run(scene):
    done = run(sys.executable, "-c", PEAK_OF_A_RUN, *scene)
    assert done.returncode == 0, done.stderr
    peak = float(done.stdout)
    assert 0.6 < estimated_memory(load_scene(scene[0], scene[1:])).bytes / peak < 2.0
