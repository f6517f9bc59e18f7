"""Error estimates of eigenvalues in a richer space: a higher degree or bisected elements."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, get_args

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
"""Highest degree of each backend."""


def estimate_errors(
    result: Result,
    richer: Scene | None = None,
    *,
    steps: int = 2,
    listener: Callable[[str], None] | None = None,
) -> ErrorEstimate:
    """Estimate the errors of the eigenvalues of a scene in a richer space; collective.

    If left eigenvectors are needed and missing, the scene is solved again with them; compute them
    with ``run_modes(scene, left=True)`` to avoid this. The estimate needs one factorisation of the
    richer scene, and in each step a block of solves for the right and one for the left vectors, but
    no eigensolution (:mod:`cea.nested.estimate`). A better contact rule in the richer scene counts.

    Parameters
    ----------
    result
        Modes of the scene.
    richer
        A richer scene; by default that with a degree more (:func:`richer_scene`).
    steps
        Number of block inverse iterations; one does not give an estimate of the remaining error.
    listener
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        If there are no modes, or the scenes have different bodies.
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
        bodies = system.bodies.items()
        step = of_system([of_body(result.bodies[name], body) for name, body in bodies])
    try:
        with timer("krylov"), factors_of(scene):
            return error_estimate(result.modes, matrices, step, steps=steps)
    finally:
        destroy(step)
        release(matrices)


def richer_scene(scene: Scene, by: Enrichment | None = "degree") -> Scene:
    """Return the scene with the space of every body enriched; shapes and contacts do not change.

    The new spaces contain the old ones, with three exceptions: curved Lagrange cells, whose
    geometry is refined too to include its error; NURBS of higher continuity; and bisection of
    elements ``through`` given coordinates, if the number of elements of a part does not double.

    Parameters
    ----------
    scene
        The scene to enrich.
    by
        ``"degree"``: one degree higher; NURBS keep their continuity.
        ``"bisection"``: twice the elements along each direction.
        ``"smooth"``: one degree and one continuous derivative higher, which adds few unknowns;
        NURBS only.
        None: a choice that also shows the errors of singular solutions at moderate cost. In the
        plane bisection; in three dimensions one degree higher, smooth for NURBS, and bisection at
        the highest degree.

    Raises
    ------
    InputError
        If a degree is already the highest, or the mesh to bisect has no numbers of elements.
    """
    if by not in (None, *get_args(Enrichment)):
        raise InputError("by", by, " or ".join(map(repr, get_args(Enrichment))))
    bodies = {
        name: replace(body, mesh=_enriched(f"bodies.{name}.mesh", body, by))
        for name, body in scene.bodies.items()
    }
    return replace(scene, bodies=bodies)


def _enriched(field: str, body: BodySpec, by: Enrichment | None) -> MeshSpec:
    """Return the mesh of a body with its space enriched; ``field`` is the path of the mesh."""
    mesh, highest = body.division, _HIGHEST[body.backend]
    degree = max(mesh.degree) if isinstance(mesh, IgaMesh) else body.fe_degree or 0
    if by is None:
        by = "smooth" if body.backend == "iga" else "degree"
        if mesh is not None and mesh.elements and (body.dim == 2 or degree >= highest):
            by = "bisection"
    if by == "smooth" and body.backend == "fe":
        raise InputError("by", by, "'degree' or 'bisection' for Lagrange elements")
    if by != "bisection" and degree >= highest:
        allowed = f"below {highest} to be raised; bisect elements instead"
        raise InputError(f"{field}.degree", degree, allowed)
    if mesh is None:
        if by != "degree":
            raise InputError(field, by, "'degree': cells of a mesh file cannot be bisected")
        return replace(body.mesh, degree=degree + 1)
    if by == "bisection":
        if mesh.elements is None:
            allowed = "left out, with elements given instead, for bisection"
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
