"""The scene in a richer space: a degree more, or elements bisected."""

from dataclasses import replace
from typing import Literal, get_args

from cea.errors import InputError
from meshes.mesh_file import MeshFile
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.spec.body import BodySpec, MeshSpec
from scenes.spec.reading import Scene

Enrichment = Literal["degree", "bisection", "smooth"]

_HIGHEST = {"fe": 4, "iga": 8}
"""Highest degrees of the backends."""


def richer_scene(scene: Scene, by: Enrichment | None = "degree") -> Scene:
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
        None: what shows errors of singular solutions too, and is not too dear: bisection in the
        plane, in space a degree more, for NURBS smooth; where there is no degree more bisection.

    Raises
    ------
    InputError
        When a degree is the highest already, or a mesh is not made of elements along directions.
    """
    if by not in (None, *get_args(Enrichment)):
        raise InputError("by", by, " or ".join(map(repr, get_args(Enrichment))))
    bodies = {
        name: replace(body, mesh=_mesh(f"bodies.{name}.mesh", body, by or _way(body)))
        for name, body in scene.bodies.items()
    }
    return replace(scene, bodies=bodies)


def _way(body: BodySpec) -> Enrichment:
    mesh = body.mesh.iga if body.backend == "iga" else body.mesh.fe
    if (
        mesh is not None
        and mesh.elements
        and (body.dim == 2 or _degree(body) >= _HIGHEST[body.backend])
    ):
        return "bisection"
    return "smooth" if body.backend == "iga" else "degree"


def _degree(body: BodySpec) -> int:
    iga = body.mesh.iga
    return (body.fe_degree or 0) if body.backend == "fe" or iga is None else max(iga.degree)


def _mesh(field: str, body: BodySpec, by: Enrichment) -> MeshSpec:
    mesh, fe, iga, degree = body.mesh, body.mesh.fe, body.mesh.iga, _degree(body)
    if by == "smooth" and body.backend == "fe":
        raise InputError("by", by, "'degree' or 'bisection' for Lagrange elements")
    if by != "bisection" and degree >= _HIGHEST[body.backend]:
        allowed = f"below {_HIGHEST[body.backend]} to be raised, or elements bisected"
        raise InputError(f"{field}.degree", degree, allowed)
    if isinstance(body.geometry, MeshFile):
        if by != "degree":
            raise InputError(field, by, "'degree': cells of a file stay as they are")
        return replace(mesh, degree=degree + 1)
    if body.backend == "iga" and iga is not None:
        if by == "bisection":
            return replace(mesh, iga=replace(iga, elements=tuple(2 * n for n in iga.elements)))
        continuity = iga.continuities if by == "degree" else iga.continuity
        if by == "smooth" and continuity is not None:
            continuity = tuple(c + 1 for c in continuity)
        raised = tuple(q + 1 for q in iga.degree)
        return replace(mesh, iga=replace(iga, degree=raised, continuity=continuity))
    assert fe is not None
    if by == "bisection":
        if fe.elements is None:
            raise InputError(f"{field}.fe.size", fe.size, "left out: elements that can be bisected")
        return replace(mesh, fe=replace(fe, elements=tuple(2 * n for n in fe.elements)))
    geometry = None if fe.geometry_degree is None else min(fe.geometry_degree + 1, _HIGHEST["fe"])
    if isinstance(body.geometry, VentilatedDisc):
        geometry = min(geometry or degree + 1, MAX_CURVED)
    return replace(mesh, fe=replace(fe, degree=degree + 1, geometry_degree=geometry))
