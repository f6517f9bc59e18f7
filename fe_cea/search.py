"""Candidates of point location: which facets a line of limited reach through a point may meet."""

from dataclasses import dataclass
from functools import cached_property

import basix
import numpy as np

from cea.arrays import Floats, Ints
from fe_cea.boxes import Boxes
from fe_cea.facets import FacetLayer

_BULGE_SAFETY = 1.1
"""Margin on the sampled bound of how far a curved facet leaves the box of its corners."""
_NEAR = 1.05
"""Lines that pass a facet's ball by less than this part of its radius are tried: near misses."""


@dataclass(frozen=True)
class FacetBounds:
    """Boxes and balls that hold the facets of a surface.

    Parameters
    ----------
    layer
        The facets.
    """

    layer: FacetLayer

    @cached_property
    def boxes(self) -> tuple[Floats, Floats]:
        """Least and greatest coordinates (m) on each facet, (n, dim) each.

        The box of the corners, widened by a bound of the bulge: the largest distance of a node
        from the straight facet times the Lebesgue constant of the nodes.
        """
        facet = self.layer.geometry.facet
        linear = basix.create_element(
            basix.ElementFamily.P, facet.cell_type, 1, basix.LagrangeVariant.equispaced
        )
        nodes, corners = self.layer.facet_nodes, self._corners
        bulge = nodes - np.einsum(
            "kv,nvi->nki", linear.tabulate(0, facet.points)[0, :, :, 0], corners
        )
        sample = basix.create_lattice(facet.cell_type, 24, basix.LatticeType.equispaced, True)
        lebesgue = np.abs(facet.tabulate(0, sample)[0]).sum(axis=1).max()
        margin = _BULGE_SAFETY * lebesgue * np.abs(bulge).max(axis=1)
        return corners.min(axis=1) - margin, corners.max(axis=1) + margin

    @cached_property
    def balls(self) -> tuple[Floats, Floats]:
        """Centres (m), (n, dim), and radii (m), (n,), about the corners, widened as the boxes."""
        corners = self._corners
        centre = corners.mean(axis=1)
        margin = np.linalg.norm(corners.min(axis=1) - self.boxes[0], axis=1)
        farthest = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
        return centre, farthest + margin

    @property
    def _corners(self) -> Floats:
        """Corners (m) of the facets, the first of their nodes, (n, n_corners, dim)."""
        count = len(basix.topology(self.layer.geometry.facet.cell_type)[0])
        return self.layer.facet_nodes[:, :count]

    @cached_property
    def _boxes(self) -> Boxes:
        return Boxes(*self.boxes)

    def within(self, x: Floats, reach: float) -> tuple[Ints, Ints]:
        """Points and facets whose box comes within reach of them, one pair a row."""
        # Room for rounding, beside a reach that may be zero.
        room = reach + 1e-6 * 2 * float(self.balls[1].max())
        return self._boxes.within(x, room)

    def near_lines(
        self, point: Ints, element: Ints, x: Floats, direction: Floats, reach: float
    ) -> np.ndarray:
        """True for pairs whose line, as far as it reaches, comes near the ball of the facet."""
        centre, radius = self.balls
        offset = centre[element] - x[point]
        aim = direction[point]
        along = np.einsum("ni,ni->n", offset, aim)
        across = np.linalg.norm(offset - along[:, None] * aim, axis=1)
        near = _NEAR * radius[element]
        return (across <= near) & (np.abs(along) <= reach + near)
