"""Gmsh meshes of the shapes: structured between breaks, or unstructured of a given size."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

import gmsh
import numpy as np

from cea.errors import require
from meshes.breaks import Breaks
from meshes.lattice import lattices
from meshes.outline import MeshArrays, mesh_outline
from meshes.patches import Patches
from meshes.placement import Placement
from meshes.shapes import Shape

Cell = Literal["tetrahedron", "hexahedron", "triangle", "quadrilateral"]

MAX_GEOMETRY_ORDER = 4
"""Highest order of the geometry that is built."""

_STRUCTURED = {"hexahedron": ("Hexahedron", "Quadrangle"), "quadrilateral": ("Quadrangle", "Line")}
"""Gmsh's names of cells and their facets."""
_UNSTRUCTURED = {"tetrahedron": ("Tetrahedron", "Triangle"), "triangle": ("Triangle", "Line")}
_DIMENSION = {"tetrahedron": 3, "hexahedron": 3, "triangle": 2, "quadrilateral": 2}
_IN_PLACE = Placement()


@contextmanager
def gmsh_mesh(
    shape: Shape,
    cell: Cell,
    order: int,
    *,
    breaks: Breaks | None = None,
    size: float | None = None,
    placement: Placement = _IN_PLACE,
    comm: Any = None,
) -> Iterator[Any]:
    """Mesh a shape with gmsh, and end gmsh when the block is left.

    Curved cells are polynomials through the Gauss-Lobatto points of the circles (see
    :mod:`meshes.nodes`); up to order 2 these are the nodes. The physical surfaces (curves in the
    plane) bear the names ``shape.surfaces``; the one physical group of cells is ``volume``.

    Parameters
    ----------
    shape
        The shape.
    cell
        ``hexahedron``, ``quadrilateral``: one element per cell of the breaks; ``tetrahedron``,
        ``triangle``: unstructured.
    order
        Order of the geometry, 1 to 4.
    breaks
        Element boundaries of a structured mesh along the directions of the shape (m, degrees).
    size
        Target edge length of an unstructured mesh (m).
    placement
        Where the shape is put.
    comm
        MPI communicator (mpi4py): gmsh runs on its rank 0 only; None runs it on every caller.

    Yields
    ------
    gmsh.model
        The model; on ranks other than 0 it is empty, and only there to be passed on.

    Raises
    ------
    ValueError
        When the input is refused.
    RuntimeError
        When gmsh is in use already, or fails.
    """
    _check(shape, cell, order, breaks, size)
    here = comm is None or comm.rank == 0
    failure: Exception | None = None
    if here:
        if gmsh.isInitialized():
            raise RuntimeError("gmsh is in use already: leave one gmsh_mesh before the next")
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        if here:
            try:
                gmsh.option.setNumber("General.Terminal", 0)
                gmsh.option.setNumber("General.NumThreads", 1)
                if size is not None:
                    mesh = mesh_outline(shape, order, size)
                    families = _UNSTRUCTURED[cell]
                else:
                    families = _STRUCTURED[cell]
                    mesh = _structured(shape, breaks or (), order, families)
                _fill(shape, mesh, order, families, placement)
            except Exception as error:
                failure = error
        if comm is not None:
            # Told to every rank, so that none waits for a mesh that never comes.
            failure = comm.bcast(failure, root=0)
        if failure is not None:
            raise failure
        yield gmsh.model
    finally:
        if here:
            gmsh.finalize()


def _check(shape: Shape, cell: str, order: int, breaks: Breaks | None, size: float | None) -> None:
    require(not isinstance(shape, Patches), "shape", shape.shape, "a shape that can be meshed")
    dim = len(shape.directions)
    fitting = [name for name, d in _DIMENSION.items() if d == dim]
    require(cell in fitting, "cell", cell, f"{' or '.join(fitting)} for shape = {shape.shape!r}")
    require(1 <= order <= MAX_GEOMETRY_ORDER, "order", order, f"1 to {MAX_GEOMETRY_ORDER}")
    if cell in _UNSTRUCTURED:
        require(size is not None and 0 < size < np.inf, "size", size, "a positive length (m)")
        require(breaks is None, "breaks", breaks, f"None: a {cell} mesh is unstructured")
        return
    require(size is None, "size", size, f"None: a {cell} mesh follows the breaks")
    along = ", ".join(shape.directions)
    if breaks is None or len(breaks) != dim:
        raise ValueError(f"breaks = {breaks!r}: one array along each of {along}")
    for name, values, (low, high) in zip(shape.directions, breaks, shape.extent, strict=True):
        rising = len(values) > 1 and bool((np.diff(values) > 0).all())
        require(
            rising and bool(np.isclose([values[0], values[-1]], [low, high], rtol=1e-12).all()),
            f"breaks of {name}",
            values,
            f"rising, from {low} to {high}",
        )
    if shape.directions[1] == "theta":
        step = float(np.diff(breaks[1]).max())
        require(step < 180, "breaks of theta", step, "less than 180 degrees apart")


def _structured(shape: Shape, breaks: Breaks, order: int, families: tuple[str, str]) -> MeshArrays:
    """Mesh on the lattices of the breaks.

    Gmsh's own transfinite mesher would need one entity per break cell to follow uneven breaks.
    """
    points, parts = lattices(shape, tuple(np.asarray(b, dtype=float) for b in breaks), order)
    cell, facet = (_offsets(family, order) for family in families)
    facets: dict[str, list] = {name: [] for name in shape.surfaces}
    for part in parts:
        for name, region in part.sides:
            facets[name].append(part.cells(region, facet, order))
    cells = np.concatenate([p.cells(region, cell, order) for p in parts for region in p.solids])
    return MeshArrays(points, cells, {name: np.concatenate(f) for name, f in facets.items()})


def _offsets(family: str, order: int) -> Any:
    """Place of each node of a cell on its lattice, in gmsh's order, (n_nodes, dim)."""
    element = gmsh.model.mesh.getElementType(family, order)
    _, dim, _, _, local, _ = gmsh.model.mesh.getElementProperties(element)
    return np.rint((np.reshape(local, (-1, dim)) + 1) / 2 * order).astype(int)


def _fill(
    shape: Shape, mesh: MeshArrays, order: int, families: tuple[str, str], placement: Placement
) -> None:
    """Fill a new gmsh model with a placed mesh, as a discrete model."""
    gmsh.model.add(shape.shape)
    used, connected = np.unique(mesh.cells, return_inverse=True)
    number = np.zeros(len(mesh.points), dtype=np.int64)
    number[used] = np.arange(1, len(used) + 1)
    placed = placement.apply(mesh.points[used])
    dim = placed.shape[1]
    positions = np.zeros((len(used), 3))
    positions[:, :dim] = placed

    entities = {name: gmsh.model.addDiscreteEntity(dim - 1) for name in shape.surfaces}
    volume = gmsh.model.addDiscreteEntity(dim, boundary=list(entities.values()))
    cell, facet = (gmsh.model.mesh.getElementType(family, order) for family in families)
    gmsh.model.mesh.addNodes(dim, volume, number[used], positions.ravel())
    for name, tag in entities.items():
        gmsh.model.mesh.addElementsByType(tag, facet, [], number[mesh.facets[name]].ravel())
        gmsh.model.addPhysicalGroup(dim - 1, [tag], name=name)
    gmsh.model.mesh.addElementsByType(volume, cell, [], connected.ravel() + 1)
    gmsh.model.addPhysicalGroup(dim, [volume], name="volume")
    gmsh.model.mesh.reclassifyNodes()
