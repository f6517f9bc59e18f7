"""NURBS patches of shapes: exact geometry, joints, named faces; patches as numbers and in files."""

from dataclasses import replace

import numpy as np
import pytest
from blocks import alone, scene_body
from covering import covering
from iga_data import basis_on_grid, body, slow_matrices
from petsc_matrices import to_scipy

from cea.errors import InputError
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import NurbsPatch, nurbs_shape
from meshes.patches import GivenPatch, NurbsFile, Patches
from meshes.shapes import Annulus, Ring, RingSector, Sector
from scenes import run_modes
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene


def test_breaks_of_arcs_are_at_their_angles() -> None:
    shape = RingSector(0.8, 1.7, -70.0, 100.0)
    breaks, angles = breaks_of(shape, (2, 9)), []
    for patch in nurbs_shape(shape, breaks)[0]:
        basis = basis_on_grid(patch, [np.array([1.0]), patch.breaks[1]])
        x, y = (basis @ patch.control_points.reshape(-1, 2)).T
        angles += np.rad2deg(np.arctan2(y, x)).tolist()
    np.testing.assert_allclose(np.unique(np.round(angles, 8)), breaks[1], atol=1e-7)


def given(patch: NurbsPatch) -> GivenPatch:
    """A patch as the plain numbers of a scene."""
    return GivenPatch(
        degrees=patch.degrees,
        knots=tuple(tuple(k.tolist()) for k in patch.knots),
        control_points=patch.control_points.tolist(),
        weights=patch.weights.tolist(),
    )


def test_given_patches_are_the_shape_they_describe() -> None:
    """A quarter of an annulus as numbers: the same matrices; placed like any shape."""
    shape = Sector(0.8, 1.7, 0.0, 80.0, -0.1, 0.2)
    ((patch,), _) = nurbs_shape(shape, breaks_of(shape, (1, 1, 1)))
    patches = Patches((given(patch),), {"rim": ((0, 0, 1),), "top": ((0, 2, 1),)})
    assert patches.directions == ("u", "v", "w")
    assert patches.surfaces == ("rim", "top")
    ours = body(patches, (2, 2, 1), (2, 3, 2))
    same = body(shape, (2, 2, 1), (2, 3, 2))
    assert ours.num_scalar_dofs == same.num_scalar_dofs
    assert ours.surfaces["rim"].area == pytest.approx(same.surfaces["outer"].area, rel=1e-14)
    # The middle break of the arc has another parameter: even in the parameter, not in the angle.
    middle = breaks_of(patches, (2, 2, 1))[1][1]
    assert middle == 0.5
    difference = abs(to_scipy(ours.mass()) - to_scipy(same.mass())).max()
    assert difference < 1e-14 * abs(to_scipy(same.mass())).max()


def bent() -> GivenPatch:
    """Curved patch of mixed degrees, uneven knots, one of them twice, over other ranges."""
    knots = ((1.0, 1.0, 1.0, 1.0, 2.5, 2.5, 4.0, 4.0, 4.0, 4.0), (-1.0, -1.0, 0.2, 1.0, 1.0))
    x, y = np.meshgrid(np.linspace(0, 2, 6), [0.0, 0.7, 1.0], indexing="ij")
    points = np.stack([x - 0.1 * y**2, y + 0.2 * np.sin(2 * x)], axis=-1)
    weights = 1 + 0.3 * np.cos(x + y)
    return GivenPatch((3, 1), knots, points.tolist(), weights.tolist())


@pytest.mark.parametrize("degree", [(3, 1), (3, 2), (4, 3), (8, 8)])
def test_given_knots_are_kept(degree: tuple[int, int]) -> None:
    """Elements divide the scaled range evenly beside the knots; inner knots stay as smooth."""
    patches = Patches((bent(),), {"low": ((0, 1, 0),)})
    part = body(patches, (3, 2), degree)
    (patch,) = part.space.multipatch.patches
    np.testing.assert_allclose(patch.breaks[0], [1, 2, 2.5, 3, 4], atol=1e-15)
    np.testing.assert_allclose(patch.breaks[1], [-1, 0, 0.2, 1], atol=1e-15)
    assert (patch.knots[0] == 2.5).sum() == 2 + degree[0] - 3
    assert (np.abs(patch.knots[1] - 0.2) < 1e-12).sum() == 1 + degree[1] - 1
    if max(degree) < 8:
        for ours, slow in zip((part.stiffness(), part.mass()), slow_matrices(part), strict=True):
            assert np.abs(to_scipy(ours).toarray() - slow).max() <= 1e-13 * np.abs(slow).max()


LINE = (0.0, 0.0, 1.0, 1.0)
SQUARE = (((0.0, 0.0), (0.0, 1.0)), ((1.0, 0.0), (1.0, 1.0)))
PLAIN = GivenPatch((1, 1), (LINE, LINE), SQUARE)
SOLID = GivenPatch((1, 1, 1), (LINE, LINE, LINE), np.indices((2, 2, 2)).T.tolist())


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"knots": ((0.0, 0.0, 1.0, 0.5), LINE)}, r"knots\[0\]"),
        ({"knots": (LINE, (0.0, 0.0, 0.5, 0.5, 1.0, 1.0))}, r"knots\[1\].*continuity 0"),
        ({"knots": (LINE, (0.0, 0.0, 0.5, 1.0, 1.0))}, r"control_points.*\(2, 3, 2\)"),
        ({"control_points": (((0.0, 0.0), (0.0, 1.0)), ((1.0, 0.0),))}, "control_points"),
        ({"weights": ((1.0, 1.0), (1.0, 0.0))}, "weights = 0.0: positive"),
    ],
)
def test_wrong_patches_are_refused(change: dict, field: str) -> None:
    with pytest.raises(InputError, match=field):
        replace(PLAIN, **change)


@pytest.mark.parametrize(
    ("patches", "faces", "field"),
    [
        ((PLAIN, SOLID), {}, r"patches = \[2, 3\]"),
        ((PLAIN,), {"left": ((1, 0, 0),)}, r"faces\[left\]"),
        ((PLAIN,), {"left": ((0, 0, 0), (0, 0, 0))}, r"faces\[left\]"),
    ],
)
def test_wrong_faces_are_refused(patches, faces: dict, field: str) -> None:
    with pytest.raises(InputError, match=field):
        Patches(patches, faces)


SHAPES = {3: Annulus(0.5, 1.0, 0.0, 0.25), 2: Ring(0.5, 1.0)}
ELEMENTS = {3: (2, 8, 1), 2: (2, 8)}


def written(folder, ending, dim):
    """A file of the quarters of a ring; the .xml names the outer faces, as boundary 2, ``rim``."""
    splinepy = pytest.importorskip("splinepy")
    made, _ = nurbs_shape(SHAPES[dim], breaks_of(SHAPES[dim], ELEMENTS[dim]))
    fastest_first = tuple(range(dim))[::-1]  # as splinepy lists points
    patches = [
        splinepy.NURBS(
            degrees=list(patch.degrees),
            knot_vectors=[k.tolist() for k in patch.knots],
            control_points=patch.control_points.transpose(*fastest_first, dim).reshape(-1, dim),
            weights=patch.weights.T.reshape(-1, 1),
        )
        for patch in made
    ]
    file = folder / f"ring{ending}"
    if ending == ".json":
        splinepy.io.json.export(str(file), patches)
        return str(file)
    multipatch = splinepy.Multipatch(patches)
    multipatch.determine_interfaces()
    multipatch.boundary_from_function(lambda x: np.hypot(x[:, 0], x[:, 1]) > 0.9, boundary_id=2)
    splinepy.io.gismo.export(str(file), multipatch, labeled_boundaries=True)
    file.write_text(file.read_text().replace('"BID2"', '"rim"'))
    return str(file)


@pytest.mark.parametrize(("ending", "dim"), covering((".json", ".xml"), (2, 3), strength=1))
def test_a_ring_of_a_file_has_the_modes_of_the_shape(tmp_path, ending, dim):
    outer = [[patch, 0, 1] for patch in range(4)]
    read = {"shape": "nurbs_file", "file": written(tmp_path, ending, dim), "unit": "m"}
    shape = {"shape": SHAPES[dim].shape, "inner_radius": 0.5, "outer_radius": 1.0}
    shape |= {"bottom": 0.0, "top": 0.25} if dim == 3 else {}
    frequencies = []
    for geometry, elements in (
        (read | {"faces": {"outer": outer}}, [2, 2, 1][:dim]),
        (shape, list(ELEMENTS[dim])),
    ):
        body = scene_body("iga", geometry, elements, supports=[{"surface": "outer"}])
        frequencies.append(np.sort(run_modes(read_scene(alone(body, 0.9))).frequencies))
    found, expected = frequencies
    assert len(found) == len(expected) > 5
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_named_boundaries_are_surfaces_and_units_are_told(tmp_path):
    file = written(tmp_path, ".xml", 3)
    read = NurbsFile(file, "mm")
    assert read.given.faces["rim"] == tuple((patch, 0, 1) for patch in range(4))
    assert "rim" in read.surfaces
    points = np.concatenate([patch.points.reshape(-1, 3) for patch in read.given.patches])
    assert np.abs(points).max() == pytest.approx(1e-3, rel=1e-12)
    for unit, units in ((None, "SI"), ("mm", "other")):
        body = scene_body("iga", {"shape": "nurbs_file", "file": file, "unit": unit}, [2, 2, 1])
        with pytest.raises(SceneError, match=f"bodies.part.geometry.unit = {unit!r}: "):
            read_scene(alone(body) | {"units": units})
    body["geometry"].pop("unit")
    assert read_scene(alone(body) | {"units": "other"}).bodies["part"].geometry.extent[0][1] == 1.0


@pytest.mark.parametrize(
    ("name", "content", "changes", "words"),
    [
        ("a.json", "{}", {}, "not follow its format"),
        ("a.xml", "<xml>", {}, "not follow its format"),
        ("a.xml", "<xml></xml>", {}, "at least one patch|patches"),
    ],
)
def test_files_that_are_refused(tmp_path, name, content, changes, words):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=words):
        NurbsFile(**{"file": str(tmp_path / name), "unit": "m", **changes})
