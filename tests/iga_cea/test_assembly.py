"""Matrices of NURBS bodies against slow loops, whatever degree, continuity and joints."""

import numpy as np
import pytest
from bodies import nurbs_body
from iga_data import STEEL, TILTED, body, scipy_of, slow_matrices, turned

from cea.body import Body
from meshes.nurbs_shapes import nurbs_shape
from meshes.shapes import Box, Disc, RingSector, Sector

BOX = Box((2.0, 1.0, 0.5))


def assert_agrees_with_slow_loops(part: Body) -> None:
    for ours, slow in zip((part.stiffness(), part.mass()), slow_matrices(part), strict=True):
        assert np.abs(scipy_of(ours).toarray() - slow).max() <= 1e-13 * np.abs(slow).max()


@pytest.mark.parametrize("q", [2, 3, 4, 5, 6, 8])
def test_every_degree_in_the_plane(q: int) -> None:
    """Continuity 0 along one parameter, the highest along the other."""
    shape = RingSector(0.8, 1.7, 20.0, 85.0)
    assert_agrees_with_slow_loops(body(shape, (2, 3), (q - 1, q), continuity=(0, q - 1)))


@pytest.mark.parametrize("q", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("axis", range(3))
def test_every_degree_in_space(axis: int, q: int) -> None:
    degree = [1, 1, 1]
    degree[axis] = q
    continuity = [0, 0, 0]
    continuity[axis] = q // 2
    elements = [1, 1, 1]
    elements[axis] = 3
    assert_agrees_with_slow_loops(body(BOX, elements, degree, continuity=continuity))


@pytest.mark.parametrize(("axes", "flip"), [((1, 2, 0), 0), ((2, 1, 0), 2), ((0, 2, 1), 1)])
def test_odd_orientations_in_space(axes: tuple[int, ...], flip: int) -> None:
    halves = [
        nurbs_shape(
            Sector(0.8, 1.7, a, b, -0.1, 0.2),
            (np.array([0.8, 1.1, 1.7]), np.array([a, b]), np.array([-0.1, 0.2])),
            TILTED,
        ).patches[0]
        for a, b in ((10.0, 40.0), (40.0, 95.0))
    ]
    patches = [halves[0], turned(halves[1], axes, flip)]
    part = nurbs_body("part", patches, {}, (2, 2, 2), material=STEEL)
    assert part.num_scalar_dofs == 4 * 5 * 3
    assert_agrees_with_slow_loops(part)


@pytest.mark.parametrize("elements", [(1, 4, 1), (2, 8, 2)])
def test_collapsed_edges(elements: tuple[int, ...]) -> None:
    """Elements at the axis of a disc have several functions of one dof."""
    assert_agrees_with_slow_loops(body(Disc(1.2, -0.1, 0.2), elements, (2, 2, 1)))
