"""Scenes on boxes divided into simplices: structured meshes of triangles and tetrahedra."""

from pathlib import Path

import numpy as np
import pytest
from reference_data import BLOCK_BODIES, DRUM_BODIES, compare, exact, plane_meshes, solve

from cea.timing import StageTimer
from scenes import run_scene
from scenes.building.build import build_bodies
from scenes.spec.reading import load_scene

MESHES = {
    "drum": (DRUM_BODIES, ([2, 20], [2, 16])),
    "blocks": (BLOCK_BODIES, ([8, 3], [7, 4])),
}
HIGHEST = {"drum": 2.2, "blocks": 2.2}


def errors(scene, degree, finer):
    """Relative errors on triangles whose boxes are so many times finer."""
    bodies, elements = MESHES[scene]
    numbers = {body: [finer * n for n in each] for body, each in zip(bodies, elements, strict=True)}
    meshes = plane_meshes("fe", degree, numbers, cell="triangle")
    found = compare(
        solve(scene, HIGHEST[scene], meshes, "fe"), exact(scene, HIGHEST[scene]), HIGHEST[scene]
    )
    assert found.complete
    return found.errors.max()


@pytest.mark.parametrize("scene", ["blocks", pytest.param("drum", marks=pytest.mark.slow)])
def test_divided_quadrilaterals_converge_to_the_exact_spectrum(scene):
    coarse, fine = (errors(scene, 2, finer) for finer in (1, 2))
    assert fine < 1e-3
    assert np.log2(coarse / fine) > 3


def test_divided_hexahedra_have_the_modes_of_hexahedra():
    """On the same nodes, of fewer functions: stiffer by a little."""
    held = ["bodies.disc.mesh.fe={elements=[3, 24, 1], through={r=[0.1]}}"]
    divided = ["bodies.disc.mesh.fe={cell='tetrahedron', elements=[3, 24, 1], through={r=[0.1]}}"]
    boxes, tetrahedra = (
        run_scene(load_scene(Path("disc"), overrides, "fe")) for overrides in (held, divided)
    )
    assert tetrahedra.system.size == boxes.system.size
    stiffer = tetrahedra.modes.frequencies[:8] / boxes.modes.frequencies[:8]
    assert stiffer.min() > 1
    assert stiffer.max() < 1.1


def test_boxes_of_simplices_pass_through_coordinates():
    mesh = "{cell='tetrahedron', degree=1, elements=[3, 8, 1], through={r=[0.1]}}"
    scene = load_scene(Path("disc"), [f"bodies.disc.mesh.fe={mesh}"], "fe")
    disc = build_bodies(scene, StageTimer())["disc"]
    radius = np.hypot(*disc.volume_sample(1).points[:, :2].T)
    assert np.isclose(radius, 0.1, rtol=1e-12).any()
    assert len(disc.volume_sample(1).cells) == 6 * 3 * 8
