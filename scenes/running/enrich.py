"""The scene in a richer space: a degree more, or elements bisected."""

from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from cea.errors import InputError
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
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
    field = f"bodies.{name}.mesh"
    degree = body.fe_degree if body.backend == "fe" else max(_iga(body, field).degree)
    if by == "smooth" and body.backend == "fe":
        raise InputError("by", by, f"'degree' or 'bisection' for {name}, of Lagrange elements")
    if by != "bisection" and (degree is None or degree >= _HIGHEST[body.backend]):
        allowed = f"below {_HIGHEST[body.backend]} to be raised, or elements bisected"
        raise InputError(f"{field}.degree", degree, allowed)
    if isinstance(body.geometry, MeshFile):
        if by != "degree" or degree is None:
            raise InputError(field, by, "'degree': cells of a file stay as they are")
        return replace(body, mesh=replace(body.mesh, degree=degree + 1))
    if body.backend == "iga":
        mesh = _iga(body, field)
        return replace(body, mesh=replace(body.mesh, iga=_ENRICHED[by](mesh)))
    return replace(body, mesh=_lagrange(body, by, field))


def _iga(body: BodySpec, field: str) -> IgaMesh:
    if body.mesh.iga is None:
        raise InputError(f"{field}.iga", None, "needed for 'iga'")
    return body.mesh.iga


def _raised(mesh: IgaMesh) -> IgaMesh:
    continuity = mesh.continuity or tuple(q - 1 for q in mesh.degree)
    return replace(mesh, degree=tuple(q + 1 for q in mesh.degree), continuity=continuity)


def _bisected(mesh: IgaMesh) -> IgaMesh:
    return replace(mesh, elements=tuple(2 * n for n in mesh.elements))


def _smoother(mesh: IgaMesh) -> IgaMesh:
    continuity = None if mesh.continuity is None else tuple(c + 1 for c in mesh.continuity)
    return replace(mesh, degree=tuple(q + 1 for q in mesh.degree), continuity=continuity)


_ENRICHED = {"degree": _raised, "bisection": _bisected, "smooth": _smoother}


def _lagrange(body: BodySpec, by: Enrichment, field: str) -> MeshSpec:
    fe = body.mesh.fe
    assert fe is not None
    if by == "bisection":
        return replace(body.mesh, fe=_divided(fe, field))
    geometry = None if fe.geometry_degree is None else fe.geometry_degree + 1
    if isinstance(body.geometry, VentilatedDisc):
        geometry = min(geometry or fe.degree + 1, MAX_CURVED)
    elif geometry is not None:
        geometry = min(geometry, _HIGHEST["fe"])
    return replace(body.mesh, fe=replace(fe, degree=fe.degree + 1, geometry_degree=geometry))


def _divided(fe: FeMesh, field: str) -> FeMesh:
    if fe.elements is None:
        raise InputError(f"{field}.fe.size", fe.size, "left out: elements that can be bisected")
    return replace(fe, elements=tuple(2 * n for n in fe.elements))
