"""Newton steps and bounds of cells for the location of points on curved surfaces along directions.

For a point x with direction d and a surface element with position F(xi), solve
F(xi) - s d = x for xi and the signed distance s.
"""

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from cea.arrays import Floats, Ints
from cea.mesh import lattice
from cea.surface_points import SurfaceCells

_GRAZING = 1e-10  # sine between line and surface below which the step is a least-squares step
_SIDE = 4  # intervals between samples along a side of a cell
_SAFETY = 1.5  # safety factor on the sampled distance of curved cells from flat ones


def cross(tangents: Floats) -> Floats:
    """Return t1 x t2 in 3D, (t_y, -t_x) in 2D, (n, dim): normals as long as the area element."""
    if tangents.shape[1] == 2:
        t = tangents[:, :, 0]
        return np.column_stack([t[:, 1], -t[:, 0]])
    return np.cross(tangents[:, :, 0], tangents[:, :, 1])


def newton_step(tangents: Floats, direction: Floats, rest: Floats) -> Floats:
    """Return the Newton step of xi, which solves t_1 a + t_2 b - s d = rest by Cramer's rule.

    Where the line is nearly tangent to the surface, return the least-squares step.
    """
    normal = cross(tangents)
    volume = np.einsum("ni,ni->n", normal, direction)
    squares = np.einsum("nij,nij->nj", tangents, tangents).prod(axis=1)
    grazing = ~(np.abs(volume) > _GRAZING * np.sqrt(squares))
    if tangents.shape[1] == 2:
        step = rest[:, 1:] * direction[:, :1] - rest[:, :1] * direction[:, 1:]
    else:  # t_2 . (d x rest), - t_1 . (d x rest)
        turned = np.cross(direction, rest) * [[[1.0]], [[-1.0]]]
        step = np.einsum("nij,jni->nj", tangents[:, :, ::-1], turned)
    step /= np.where(grazing, 1.0, volume)[:, None]
    if grazing.any():
        # The direction is scaled to the length of the tangents, so that rcond truncates neither.
        length = np.linalg.norm(tangents[grazing], axis=1).max(axis=1)
        along = -length[:, None, None] * direction[grazing, :, None]
        inverse = np.linalg.pinv(np.concatenate([tangents[grazing], along], axis=2), rcond=1e-8)
        step[grazing] = np.einsum("nij,nj->ni", inverse[:, :-1], rest[grazing])
    return step


def near_boxes(low: Floats, high: Floats, x: Floats, reach: float) -> tuple[Ints, Ints]:
    """Return pairs of points x (m), (m, dim), and boxes within ``reach`` of each other.

    Boxes have sides along the axes, from low to high (m), (n, dim) each.
    """
    half = 0.5 * (high - low).max(axis=1) + reach
    found = cKDTree(x).query_ball_point(0.5 * (low + high), half, p=np.inf)
    box = np.repeat(np.arange(len(found)), [len(each) for each in found])
    point = np.concatenate([*found, []]).astype(np.int64)
    at = x[point]
    near = ((at >= low[box] - reach) & (at <= high[box] + reach)).all(axis=1)
    return point[near], box[near]


class CellBounds:
    """Bounding boxes and spheres of the cells of a surface; ``tangents`` gives positions."""

    def __init__(
        self, cells: SurfaceCells, tangents: Callable[[Ints, Floats], tuple[Floats, Floats]]
    ) -> None:
        self.element = cells.element
        steps = lattice(cells.corners.shape[2], _SIDE, not cells.tensor)
        t = steps / _SIDE
        at, _ = cells.coordinates(t)
        x = tangents(at.element, at.xi)[0].reshape(len(cells.element), len(t), -1)
        corner = np.flatnonzero(np.isin(steps, (0, _SIDE)).all(axis=1))
        if cells.tensor:
            ends = steps[corner] == _SIDE
            shape = np.where(ends, t[:, None], 1 - t[:, None]).prod(axis=2)
        else:  # corners in C order: the first, that along the second direction, along the first
            shape = np.column_stack([1 - t.sum(axis=1), t[:, ::-1]])
        corners = x[:, corner]
        margin = _SAFETY * np.abs(x - shape @ corners).max(axis=1)
        self.low, self.high = corners.min(axis=1) - margin, corners.max(axis=1) + margin
        self.centre = corners.mean(axis=1)
        farthest = np.linalg.norm(corners - self.centre[:, None], axis=2).max(axis=1)
        self.radius = farthest + np.linalg.norm(margin, axis=1)
        # No starting points on the edges: the tangents vanish on a collapsed edge.
        far = steps.max(axis=1) if cells.tensor else steps.sum(axis=1)
        inner = (steps > 0).all(axis=1) & (far < _SIDE)
        self.starts = at.xi.reshape(*x.shape[:2], -1)[:, inner]
        self.samples = x[:, inner]


def apart(offset: Floats, aim: Floats) -> tuple[Floats, Floats]:
    """Return components of offsets along unit directions, and distances across, (...,) each."""
    along = (offset * aim).sum(axis=-1)
    return along, np.linalg.norm(offset - along[..., None] * aim, axis=-1)
