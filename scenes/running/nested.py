"""Errors of eigenvalues in a richer space: a degree more, or elements bisected."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Literal, get_args

from cea.body import Body
from cea.eigen.pencil import release
from cea.errors import InputError, require
from cea.matrices import destroy
from cea.nested.estimate import ErrorEstimate, error_estimate
from cea.nested.prolongation import of_body, of_system
from meshes.ventilated_disc import MAX_CURVED, VentilatedDisc
from scenes.building.build import made_of
from scenes.checking.memory import factors_of
from scenes.results.result import Result
from scenes.running.modes import run_modes
from scenes.running.system import coupled
from scenes.spec.body import BodySpec
from scenes.spec.mesh import FeMesh, IgaMesh, MeshSpec
from scenes.spec.reading import Scene

Enrichment = Literal["degree", "bisection", "smooth"]

_HIGHEST = {"fe": 4, "iga": 8}
"""Highest degrees of the backends."""


def prolongation(coarse: Mapping[str, Body], fine: Mapping[str, Body]) -> Any:
    """Prolongation from the free displacements of a scene to those of a finer one; collective."""
    return of_system([of_body(coarse[name], fine[name]) for name in fine])


def estimate_errors(
    result: Result,
    richer: Scene | None = None,
    *,
    steps: int = 2,
    listener: Callable[[str], None] | None = None,
) -> ErrorEstimate:
    """Errors of the eigenvalues of a scene, estimated in a richer space; collective.

    Where the left vectors that this takes are missing, the scene is solved once more with them:
    ``run_modes(scene, left=True)`` saves that. It takes one factorisation of the richer scene, and
    in every step a block of solves for the right vectors and one for the left ones; no eigenproblem
    (:mod:`cea.nested.estimate`). What the contact rule of the richer scene does better is part of
    the error.

    Parameters
    ----------
    result
        Modes of the scene.
    richer
        A richer scene; by default the same with a degree more (:func:`richer_scene`).
    steps
        Block inverse steps; after one nothing is known of what remains.
    listener
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        When there are no modes, or the scenes are not of the same bodies.
    """
    scene = richer if richer is not None else richer_scene(result.scene)
    own, names = result.scene, list(scene.bodies)
    allowed = f"those of the coarse scene: {', '.join(own.bodies)}"
    require(names == list(own.bodies), "bodies", names, allowed)
    one_sided = own.damped or own.rotates or own.has_friction
    if one_sided and result.modes.left is None and len(result.modes):
        result = run_modes(own, left=True, bodies=result.bodies, listener=listener)
    same = {n: b for n, b in result.bodies.items() if made_of(own, n) == made_of(scene, n)}
    system, timer = coupled(scene, bodies=same, listener=listener)
    with timer("assembly"):
        matrices = system.pencil().at()
        step = prolongation(result.bodies, system.bodies)
    try:
        with timer("krylov"), factors_of(scene):
            return error_estimate(result.modes, matrices, step, steps=steps)
    finally:
        destroy(step)
        release(matrices)


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
    highest = _degree(body) >= _HIGHEST[body.backend]
    if body.division is not None and body.division.elements and (body.dim == 2 or highest):
        return "bisection"
    return "smooth" if body.backend == "iga" else "degree"


def _degree(body: BodySpec) -> int:
    mesh = body.division
    return max(mesh.degree) if isinstance(mesh, IgaMesh) else body.fe_degree or 0


def _mesh(field: str, body: BodySpec, by: Enrichment) -> MeshSpec:
    mesh, degree, highest = body.division, _degree(body), _HIGHEST[body.backend]
    if by == "smooth" and body.backend == "fe":
        raise InputError("by", by, "'degree' or 'bisection' for Lagrange elements")
    if by != "bisection" and degree >= highest:
        allowed = f"below {highest} to be raised, or elements bisected"
        raise InputError(f"{field}.degree", degree, allowed)
    if mesh is None:
        if by != "degree":
            raise InputError(field, by, "'degree': cells of a file stay as they are")
        return replace(body.mesh, degree=degree + 1)
    if by == "bisection":
        if mesh.elements is None:
            allowed = "left out: elements that can be bisected"
            raise InputError(f"{field}.fe.size", getattr(mesh, "size", None), allowed)
        finer: FeMesh | IgaMesh = replace(mesh, elements=tuple(2 * n for n in mesh.elements))
    elif isinstance(mesh, IgaMesh):
        continuity = mesh.continuities if by == "degree" else mesh.continuity
        if by == "smooth" and continuity is not None:
            continuity = tuple(c + 1 for c in continuity)
        finer = replace(mesh, degree=tuple(q + 1 for q in mesh.degree), continuity=continuity)
    else:
        own = mesh.geometry_degree
        geometry = None if own is None else min(own + 1, highest)
        if isinstance(body.geometry, VentilatedDisc):
            geometry = min(geometry or degree + 1, MAX_CURVED)
        finer = replace(mesh, degree=degree + 1, geometry_degree=geometry)
    return (
        replace(body.mesh, fe=finer) if isinstance(finer, FeMesh) else replace(body.mesh, iga=finer)
    )
