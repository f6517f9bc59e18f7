"""Lagrange elements of cells and their restrictions to facets; geometry and dofs of cells."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import basix
import numpy as np

from cea.arrays import Floats, Ints


@dataclass(frozen=True)
class FacetBasis:
    """A Lagrange element on a cell, and its restriction to facets."""

    cell: Any  # element on the reference cell (basix)

    @cached_property
    def facet(self) -> Any:
        """Element of the same degree on the reference facet (basix)."""
        dim = len(basix.topology(self.cell.cell_type)) - 2
        kind = basix.cell.sub_entity_type(self.cell.cell_type, dim, 0)
        return basix.create_element(
            self.cell.family, kind, self.cell.degree, self.cell.lagrange_variant
        )

    @cached_property
    def closure(self) -> Ints:
        """Cell dofs on each local facet in the order of the facet's dofs, (facets, n_dofs).

        Computed from values: a Lagrange function of the cell is one at its own node only.
        """
        points = self.facet.points
        reference = [
            corner + points @ tangents.T
            for corner, tangents in zip(*reference_facets(self.cell.cell_type), strict=True)
        ]
        values = [self.cell.tabulate(0, x)[0, :, :, 0] for x in reference]
        return np.argmax(values, axis=2).astype(np.int64)


def reference_facets(cell_type: Any) -> tuple[Floats, Floats]:
    """Return first corners (facets, dim) and edges (facets, dim, dim - 1) of reference facets."""
    vertices = basix.topology(cell_type)[-2]
    corners = basix.geometry(cell_type)[[v[0] for v in vertices]]
    return corners, np.asarray(basix.cell.facet_jacobians(cell_type))


def geometry_element(mesh: Any) -> Any:
    """Return the Lagrange element (basix) of the geometry of a mesh (dolfinx)."""
    cmap = mesh.geometry.cmaps[0]
    return basix.create_element(
        basix.ElementFamily.P,
        mesh.basix_cell(),
        cmap.degree,
        basix.LagrangeVariant(cmap.variant),
    )


def nodes_and_dofs(V: Any, cells: Ints) -> tuple[Floats, Ints]:
    """Return geometry nodes (m) and global scalar dofs of given cells of this rank."""
    geometry, blocks = V.mesh.geometry, V.dofmap.list[cells]
    dofs = V.dofmap.index_map.local_to_global(blocks.ravel()).reshape(blocks.shape)
    return geometry.x[geometry.dofmaps[0][cells], : geometry.dim], dofs.astype(np.int64)
