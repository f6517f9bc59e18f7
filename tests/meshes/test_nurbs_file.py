"""Bodies of NURBS patches from files of splinepy and G+Smo."""

import numpy as np
import pytest
from covering import covering

from cea.errors import InputError
from meshes.breaks import breaks_of
from meshes.nurbs_shapes import nurbs_shape
from meshes.patches import NurbsFile
from meshes.shapes import Annulus, Ring
from scenes import run_modes
from scenes.spec.reading import read_scene

splinepy = pytest.importorskip("splinepy", reason="splinepy, which writes the files, is missing")

SHAPES = {3: Annulus(0.5, 1.0, 0.0, 0.25), 2: Ring(0.5, 1.0)}
ELEMENTS = {3: (2, 8, 1), 2: (2, 8)}


def splines(dim, kind="NURBS"):
    """The quarters of a ring in splinepy, whose points run fastest along the first parameter."""
    shape = nurbs_shape(SHAPES[dim], breaks_of(SHAPES[dim], ELEMENTS[dim]))
    order = tuple(range(dim))[::-1]
    return [
        splinepy.NURBS(
            degrees=list(patch.degrees),
            knot_vectors=[k.tolist() for k in patch.knots],
            control_points=patch.control_points.transpose(*order, dim).reshape(-1, dim),
            weights=patch.weights.T.reshape(-1, 1),
        )
        for patch in shape.patches
    ]


def written(folder, ending, dim):
    """A file of the quarters; the .xml names the outer faces, as boundary 2, ``rim``."""
    patches, file = splines(dim), folder / f"ring{ending}"
    if ending == ".json":
        splinepy.io.json.export(str(file), patches)
        return str(file)
    multipatch = splinepy.Multipatch(patches)
    multipatch.determine_interfaces()
    multipatch.boundary_from_function(lambda x: np.hypot(x[:, 0], x[:, 1]) > 0.9, boundary_id=2)
    splinepy.io.gismo.export(str(file), multipatch, labeled_boundaries=True)
    file.write_text(file.read_text().replace('"BID2"', '"rim"'))
    return str(file)


def scene(geometry, dim):
    support = {"surface": "outer"}
    iga = {"degree": [2] * dim, "elements": list(ELEMENTS[dim])}
    if geometry["shape"] == "nurbs_file":
        iga["elements"] = [2, 2, 1][:dim]
    body = {"backend": "iga", "geometry": geometry, "mesh": {"iga": iga}, "supports": [support]}
    body["material"] = {"E": 1.0, "nu": 0.3, "rho": 1.0}
    return {"name": "ring", "bodies": {"ring": body}} | {
        "analysis": {"kind": "cea", "max_frequency": 0.7}
    }


@pytest.mark.parametrize(("ending", "dim"), covering((".json", ".xml"), (2, 3), strength=1))
def test_a_ring_of_a_file_has_the_modes_of_the_shape(tmp_path, ending, dim):
    file = written(tmp_path, ending, dim)
    outer = [[patch, 0, 1] for patch in range(4)]
    read = {"shape": "nurbs_file", "file": file, "unit": "m", "faces": {"outer": outer}}
    shape = {"ring": SHAPES[2], "annulus": SHAPES[3]}[SHAPES[dim].shape]
    sizes = {"inner_radius": 0.5, "outer_radius": 1.0}
    sizes |= {"bottom": 0.0, "top": 0.25} if dim == 3 else {}
    found, expected = (
        np.sort(run_modes(read_scene(scene(geometry, dim))).modes.eigenvalues.imag)
        for geometry in (read, {"shape": shape.shape, **sizes})
    )
    assert len(found) == len(expected) > 5
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_named_boundaries_are_surfaces_and_units_are_told(tmp_path):
    read = NurbsFile(written(tmp_path, ".xml", 3), "mm")
    assert read.given.faces["rim"] == tuple((patch, 0, 1) for patch in range(4))
    assert "rim" in read.surfaces
    points = np.concatenate([patch.points.reshape(-1, 3) for patch in read.given.patches])
    assert np.abs(points).max() == pytest.approx(1e-3, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "content", "changes", "words"),
    [
        ("a.json", None, {}, "a file of patches"),
        ("a.json", "", {}, "not empty"),
        ("a.json", "{}", {}, "not as its format"),
        ("a.xml", "<xml>", {}, "not as its format"),
        ("a.xml", "<xml></xml>", {}, "at least one patch|patches"),
        ("a.igs", "x", {}, "one that ends in .json or .xml"),
        ("a.json", "{}", {"unit": None}, "the unit of length"),
    ],
)
def test_what_is_refused(tmp_path, name, content, changes, words):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=words):
        NurbsFile(**{"file": str(tmp_path / name), "unit": "m", **changes})
