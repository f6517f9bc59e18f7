"""Meshes as gmsh models, so that gmsh's own Jacobians, quadrature and qualities judge them."""

from contextlib import contextmanager

import gmsh
import numpy as np

from cea.mesh import facet_nodes, lattice, matching_nodes
from meshes.unstructured import gmsh_session

FAMILIES = {
    "triangle": ("Triangle", "Line"),
    "quadrilateral": ("Quadrangle", "Line"),
    "tetrahedron": ("Tetrahedron", "Triangle"),
    "hexahedron": ("Hexahedron", "Quadrangle"),
}
"""Gmsh's names of cells and their facets."""


def _elements(family, mesh, dim, nodes):
    """Kind of element, and the nodes of each in gmsh's order, counted from 1."""
    kind = gmsh.model.mesh.getElementType(family, mesh.order)
    local = np.reshape(gmsh.model.mesh.getElementProperties(kind)[4], (-1, dim))
    if family in ("Line", "Quadrangle", "Hexahedron"):
        local = (local + 1) / 2
    ours = lattice(dim, mesh.order, mesh.is_simplex) / mesh.order
    return kind, nodes[:, matching_nodes(local, ours)].ravel() + 1


@contextmanager
def gmsh_model(mesh):
    """The mesh as a discrete model: a physical group for each surface, one for the cells."""
    with gmsh_session():
        model, dim = gmsh.model, mesh.dim
        model.add("mesh")
        cell, facet = FAMILIES[mesh.cell]
        volume = model.addDiscreteEntity(dim)
        positions = np.zeros((len(mesh.points), 3))
        positions[:, :dim] = mesh.points
        model.mesh.addNodes(dim, volume, np.arange(1, len(positions) + 1), positions.ravel())
        for name, facets in mesh.surfaces.items():
            entity = model.addDiscreteEntity(dim - 1)
            kind, nodes = _elements(facet, mesh, dim - 1, facets)
            model.mesh.addElementsByType(entity, kind, [], nodes)
            model.addPhysicalGroup(dim - 1, [entity], name=name)
        kind, nodes = _elements(cell, mesh, dim, mesh.cells)
        model.mesh.addElementsByType(volume, kind, [], nodes)
        model.addPhysicalGroup(dim, [volume], name="volume")
        model.mesh.reclassifyNodes()
        yield model


def assert_outer_facets_are_named(mesh):
    """Every shape names its whole boundary: a face that neighbours divide unlike is none of it."""
    facets = [mesh.cells[:, facet] for facet in facet_nodes(mesh.cell, mesh.order)]
    rows, count = np.unique(np.sort(np.concatenate(facets), axis=1), axis=0, return_counts=True)
    assert count.max() <= 2
    named = np.sort(np.concatenate(list(mesh.surfaces.values())), axis=1)
    assert np.array_equal(rows[count == 1], np.unique(named, axis=0))


def measures(mesh):
    """Volumes of the cells by gmsh's quadrature, Jacobians of one sign, and areas of surfaces."""
    with gmsh_model(mesh) as model:

        def integrals(dim, entity=-1):
            (kind,) = model.mesh.getElementTypes(dim, entity)
            xi, weights = model.mesh.getIntegrationPoints(kind, "Gauss8")
            found = model.mesh.getJacobians(kind, xi, entity)[1].reshape(-1, len(weights))
            assert (np.abs(np.sign(found).sum(axis=1)) == len(weights)).all()
            return np.abs(found @ weights)

        areas = {
            model.getPhysicalName(dim, tag): integrals(
                dim, model.getEntitiesForPhysicalGroup(dim, tag)[0]
            ).sum()
            for dim, tag in model.getPhysicalGroups(mesh.dim - 1)
        }
        return integrals(mesh.dim), areas


def volumes(mesh):
    """Volumes of the cells."""
    return measures(mesh)[0]
