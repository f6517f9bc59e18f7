"""Gmsh models read as plain arrays, and gmsh held for as long as one is made."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gmsh

from cea.mesh import Mesh
from cea.signals import ignore_closed_pipes
from meshes.files.body import body_mesh
from meshes.files.gmsh import arrays_of_model, content_of
from meshes.files.part import part_of


@contextmanager
def gmsh_session() -> Iterator[None]:
    """Start gmsh, silent and on one thread, and end it when the block is left."""
    if gmsh.isInitialized():
        raise RuntimeError("gmsh is in use already: end it before the next mesh")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    ignore_closed_pipes()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield
    finally:
        gmsh.finalize()


def read_gmsh(model: Any) -> Mesh:
    """Mesh of a gmsh model whose cells are all of one kind.

    Parameters
    ----------
    model
        Meshed gmsh model of order 1 to 4; its named physical groups of one dimension less than its
        cells are the surfaces.

    Raises
    ------
    InputError
        When there are no cells, or of several kinds, or they are none of a mesh.
    """
    content = content_of(arrays_of_model(model))
    groups = model.getPhysicalGroups(content.dim - 1) if content.dim else ()
    names = [model.getPhysicalName(*group) for group in groups]
    faces = {name: (f"elements:{name}",) for name in names if name}
    return body_mesh(content, part_of(content, "the model", None), faces)
