"""The scene in a richer space: a degree more, or elements bisected."""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from cea.errors import InputError
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import BodySpec, IgaMesh
from scenes.spec.reading import Scene

Enrichment = Literal["degree", "bisection", "smooth"]

_HIGHEST = {"fe": 4, "iga": 8}
"""Highest degrees of the backends."""


def richer_scene(scene: Scene, by: Enrichment = "degree") -> Scene:
    """The scene with the space of every body enriched; shapes and contacts stay.

    The new spaces hold the old ones but for curved Lagrange cells, whose geometry is refined too,
    so that its error is seen, for NURBS of higher continuity, and for stretches of elements that do
    not double where they are bisected ``through`` given coordinates.

    Parameters
    ----------
    scene
        The scene.
    by
        ``"degree"``: a degree more; NURBS keep their continuity.
        ``"bisection"``: twice the elements along each direction.
        ``"smooth"``: a degree and a continuous derivative more, which adds few unknowns; NURBS
        only.

    Raises
    ------
    InputError
        When a degree is the highest already, or a mesh is not made of elements along directions.
    """
    if by not in get_args(Enrichment):
        raise InputError("by", by, " or ".join(map(repr, get_args(Enrichment))))
    bodies = {name: _body(name, body, by) for name, body in scene.bodies.items()}
    return replace(scene, bodies=bodies)


def enriched_scene(scene: Scene) -> Scene:
    """The scene in a richer space that shows errors of singular solutions too, and is not too dear.

    In the plane elements are bisected; in space they get a degree more, and NURBS a continuous
    derivative more too. What has no degree more is bisected, what has no elements along directions
    gets a degree more.
    """
    bodies = {name: _body(name, body, _way(body)) for name, body in scene.bodies.items()}
    return replace(scene, bodies=bodies)


def _way(body: BodySpec) -> Enrichment:
    if isinstance(body.geometry, MeshFile):
        return "degree"
    mesh = body.mesh.iga if body.backend == "iga" else body.mesh.fe
    planar = len(body.geometry.directions) == 2
    highest = mesh is not None and np.max(mesh.degree) >= _HIGHEST[body.backend]
    if mesh is not None and mesh.elements and (planar or highest):
        return "bisection"
    return "smooth" if body.backend == "iga" else "degree"


def _body(name: str, body: BodySpec, by: Enrichment) -> BodySpec:
    """A body in a richer space."""
    field, shape, mesh = f"bodies.{name}.mesh", body.geometry, body.mesh
    fe, iga = mesh.fe, mesh.iga
    degree = max(iga.degree) if body.backend == "iga" and iga is not None else body.fe_degree
    if by == "smooth" and body.backend == "fe":
        raise InputError("by", by, f"'degree' or 'bisection' for {name}, of Lagrange elements")
    if by != "bisection" and (degree is None or degree >= _HIGHEST[body.backend]):
        allowed = f"below {_HIGHEST[body.backend]} to be raised, or elements bisected"
        raise InputError(f"{field}.degree", degree, allowed)
    if isinstance(shape, MeshFile):
        if by != "degree" or degree is None:
            raise InputError(field, by, "'degree': cells of a file stay as they are")
        return replace(body, mesh=replace(mesh, degree=degree + 1))
    if body.backend == "iga" and iga is not None:
        return replace(body, mesh=replace(mesh, iga=_splines(iga, by)))
    assert fe is not None
    if by == "bisection":
        if fe.elements is None:
            raise InputError(f"{field}.fe.size", fe.size, "left out: elements that can be bisected")
        finer = replace(fe, elements=tuple(2 * n for n in fe.elements))
        return replace(body, mesh=replace(mesh, fe=finer))
    geometry = None if fe.geometry_degree is None else min(fe.geometry_degree + 1, _HIGHEST["fe"])
    if isinstance(shape, VentilatedDisc):
        geometry = min(geometry or fe.degree + 1, MAX_CURVED)
    raised = replace(fe, degree=fe.degree + 1, geometry_degree=geometry)
    return replace(body, mesh=replace(mesh, fe=raised))


def _splines(mesh: IgaMesh, by: Enrichment) -> IgaMesh:
    """Splines with twice the elements, or with a degree more and their continuity, or one more."""
    if by == "bisection":
        return replace(mesh, elements=tuple(2 * n for n in mesh.elements))
    continuity = mesh.continuity
    if by == "degree":
        continuity = continuity or tuple(q - 1 for q in mesh.degree)
    elif continuity is not None:
        continuity = tuple(c + 1 for c in continuity)
    return replace(mesh, degree=tuple(q + 1 for q in mesh.degree), continuity=continuity)
