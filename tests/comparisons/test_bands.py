"""Rows of a map on the basis of their band, and what bounds keep where a contact is stiff."""

from itertools import product

import numpy as np
import pytest

from cea.reduced import model as reduced_model
from cea.reduced.greedy import Enrichment
from cea.reduced.model import ReducedModel
from cea.reduced.stored import arrays_of
from comparisons.sweep.axes import read_axis
from comparisons.sweep.bands import Bands
from comparisons.sweep.mapped import mapped
from comparisons.sweep.rows import map_row

MESHES = {
    "fe": (
        "bodies.pad.mesh.fe={cell='hexahedron',degree=2,elements=[2,3,1]}",
        "bodies.disc.mesh.fe={cell='hexahedron',degree=2,elements=[2,14,1]}",
    ),
    "iga": ("bodies.pad.mesh.iga.elements=[2,4,1]", "bodies.disc.mesh.iga.elements=[3,24,1]"),
}


def scene_of(backend, top, *axes):
    """A coarse disc and pad on a backend, to be mapped."""
    bodies = [f"bodies.{name}.backend='{backend}'" for name in ("pad", "disc")]
    window = f"analysis.max_frequency={top}"
    return mapped(
        "disc_pad", tuple(map(read_axis, axes)), (*bodies, window, *MESHES[backend]), None
    )


def filled(scene, points):
    """A reduced model with full solves at some points."""
    top = scene.max_frequency
    built = Enrichment(ReducedModel(scene.pencil, scene.box, top), scene.driver, top)
    for point in points:
        built.solve(scene.point(point), np.inf)
    return built


@pytest.fixture(scope="module")
def maps():
    made = {}

    def of(backend):
        if backend not in made:
            scene = scene_of(backend, 12e3, "mu=0:0.4:9", "P=1e9:1e10:log:8")
            ends = product((0.0, 0.2, 0.4), (1e9, 3e9, 1e10))
            made[backend] = scene, filled(scene, ends).model.small
        return made[backend]

    return of


@pytest.mark.slow
def test_rows_of_a_band_are_those_of_the_whole_basis(maps, backend):
    scene, small = maps(backend)
    tolerance, bands = 1e-7, Bands(scene, 1e-7)
    basis = bands.of(1, small)
    assert basis.size < 0.8 * small.size
    assert bands.of(6, small) is basis
    for number in (1, 4):
        others = scene.rows()[number]
        first = small.at(scene.pencil.values(scene.point((0.0, *others))))
        start = first, np.arange(len(first)), len(first)
        one, other = (map_row(each, scene, others, start, tolerance) for each in (basis, small))
        assert one.worst.max() <= tolerance
        frequency = other.frequency
        np.testing.assert_allclose(one.frequency, frequency, rtol=4e-7)
        np.testing.assert_array_equal(one.branch[0], other.branch[0])
        assert len(one.thresholds) == len(other.thresholds)
        for mine, theirs in zip(one.thresholds, other.thresholds, strict=True):
            assert abs(mine.value - theirs.value) <= mine.error + theirs.error


@pytest.mark.slow
def test_a_band_ends_where_stiffness_is_another_and_takes_in_what_it_lacks(maps):
    scene, small = maps("iga")
    bands = Bands(scene, 1e-7)
    assert [len(bands._band(number, small)) for number in (0, 3, 7)] == [6, 5, 1]
    wide = scene_of("iga", 12e3, "mu=0:0.4:9", "P=1e6:1e14:log:5")
    stiff = ReducedModel(wide.pencil, wide.box, wide.max_frequency).small
    assert [len(Bands(wide, 1e-7)._band(number, stiff)) for number in (0, 3)] == [1, 1]
    wide.driver.free()
    before = bands.of(0, small)
    values = scene.pencil.values(scene.point((0.15, *scene.rows()[4])))
    assert before.size < small.size
    bands.mend(4, [0.15])
    after = bands.of(1, small)
    assert after is not before
    assert before.size <= after.size < small.size
    assert after.at(values).worst <= max(1e-7, bands.whole.at(values).worst)
    assert bands.of(7, small).size == small.size
    assert bands.whole.size == small.size


@pytest.mark.grid(quick=1)
def test_what_is_left_out_of_residuals_makes_no_bound_however_stiff_a_contact(backend):
    scene = scene_of(backend, 6e3, "mu=0:1:3", "P=1e6:1e14:log:9")
    small = filled(scene, [(0.5, 1e10), (1.0, 1e13), (0.0, 1e14)]).model.small
    for p in (1e7, 1e10, 1e13, 1e14):
        values = scene.pencil.values(scene.point((0.3, p)))
        found = small.at(values).window
        lost = sum(
            abs(piece.coefficient.at(values)) * piece.lost * speeds
            for piece in small.pieces
            for speeds in [np.abs(found.kappa) if piece.role == "mass" else 1.0]
        )
        sizes = [np.linalg.norm(each, axis=0) for each in (found.right, found.left)]
        alone = found.certificate.conditions * small.settings.outside(found.kappa)
        alone = alone * lost**2 * sizes[0] * sizes[1] / (2 * found.speeds**2)
        assert 0 < alone.max() < 1e-14
    scene.driver.free()


def test_a_model_goes_on_from_arrays_with_the_same_numbers(backend):
    scene = scene_of(backend, 3e3, "mu=0:1:3", "P=1e8:1e10:log:3")
    first = ReducedModel(scene.pencil, scene.box, 3e3)
    grown = []
    for point in ((0.5, 1e9), (1.0, 1e10)):
        modes = scene.driver.solve(3.5e3, scene.point(point), left=True)
        grown.append(first.take(modes))
    again = ReducedModel(scene.pencil, scene.box, 3e3)
    again.restore(grown, arrays_of(first.small))
    at = scene.pencil.values(scene.point((0.3, 3e9)))
    np.testing.assert_array_equal(again.small.at(at).kappa, first.small.at(at).kappa)
    modes = scene.driver.solve(3.5e3, scene.point((0.0, 1e8)), left=True)
    for each in (first, again):
        each.take(modes)
    np.testing.assert_array_equal(again.small.at(at).kappa, first.small.at(at).kappa)
    np.testing.assert_array_equal(
        again.small.at(at).certificate.errors, first.small.at(at).certificate.errors
    )
    broken = reduced_model.Growth(2.0 * grown[0].vectors, grown[0].residuals)
    with pytest.raises(ValueError, match="not orthonormal"):
        ReducedModel(scene.pencil, scene.box, 3e3).restore([broken], arrays_of(first.small))
    scene.driver.free()
