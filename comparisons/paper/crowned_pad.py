"""Study of the crowned pad: equilibrium, contact stiffness and growth against the load.

The paper prescribes p(x) and does not study the effect of the contact scheme on steady sliding
(sections 2.3 and 3). Here each formulation solves for its own steady state, which defines p(x).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.contact.formulations import (
    Botella,
    Formulation,
    GaussPointToSurface,
    Greville,
    Grid,
    Mortar,
    NodeToSurface,
    Segments,
)
from cea.errors import InputError
from comparisons.paper.figure import BACKENDS, Figure, Mesh, Row, Tables, sector_points
from comparisons.study.session import Session
from meshes.shapes import Crowned, Sector
from scenes import Result
from scenes.spec.body import MeshSpec
from scenes.spec.reading import Scene, load_scene

CONTACT, PAD, DISC = "pad_disc", "pad", "disc"
"""Names of the contact and the bodies in the scene."""
EXACT, COLLOCATION, QUADRATURE = "segments", "collocation", "GPTS 3 × 3"
"""Labels of exact integration and of the two schemes that the paper compares."""
WEIGHTED, FINER = "collocation, area weights", "segments, finer mesh"
"""Labels of collocation with tributary areas as weights instead of equal weights, and of exact
integration on a finer mesh."""
PRESSURES = (1e5, 4e5, 2e6)  # pressures on the back of the pad (N/m^2)
RADII, ANGLES = 9, 60
"""Points across and along the pad at which pressures are compared."""
_REFINED = 1.5  # factor on the elements of the finer mesh in every direction


def formulations(mesh: Mesh) -> dict[str, Formulation]:
    """Return the formulations of a kind of mesh by label, exact integration first."""
    common = {EXACT: Segments(), "mortar": Mortar(), QUADRATURE: GaussPointToSurface(3)}
    if mesh != "NURBS":
        own = {COLLOCATION: NodeToSurface(), WEIGHTED: NodeToSurface("tributary")}
        return {**common, **own, "grid": Grid(4)}
    own_splines = {COLLOCATION: Greville(), WEIGHTED: Greville("area"), "Botella": Botella()}
    return {**common, **own_splines, "grid": Grid(10)}


def crowned_scene(
    mesh: Mesh, formulation: Formulation, pressure: float, factor: float = 1.0
) -> Scene:
    """Return the scene with elements refined by a factor; six tetrahedra per hexahedron."""
    scene = load_scene("crowned_pad", backend=BACKENDS[mesh])
    changes: dict[str, Any] = {"loads.0.pressure": pressure}
    changes |= {f"contacts.{CONTACT}.formulation": formulation}
    for name, body in scene.bodies.items():
        own: Any = getattr(body.mesh, body.backend)
        finer: Any = replace(own, elements=tuple(round(factor * n) for n in own.elements))
        if mesh == "tetrahedra":
            finer = replace(finer, cell="tetrahedron")
        changes[f"bodies.{name}.mesh"] = MeshSpec(**{body.backend: finer})
    return scene.change(changes)


@dataclass(frozen=True)
class CrownedPad(Figure):
    """Steady sliding and its modes by formulation, against the pressure on the pad."""

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Return the scenes of every formulation under every load, grouped by load."""
        scenes = {}
        for pressure in PRESSURES:
            for label, rule in formulations(mesh).items():
                scenes[f"{label}, {pressure:g}"] = crowned_scene(mesh, rule, pressure)
            finer = crowned_scene(mesh, Segments(), pressure, _REFINED)
            scenes[f"{FINER}, {pressure:g}"] = finer
        return scenes

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Run every case; rows have its distance from exact integration under the same load."""
        rows = []
        for pressure in PRESSURES:
            exact: tuple[Row, Floats] | None = None
            for label in (*formulations(mesh), FINER):
                row, own = state(session.solve(session.scene[f"{label}, {pressure:g}"]))
                exact = exact or (row, own)
                labels = {"formulation": label, "load": pressure}
                rows.append(labels | row | off(row, own, *exact))
        return {"crowned": rows}


def off(row: Row, pressure: Floats, exact: Row, its: Floats) -> Row:
    """Return the distance from exact integration: pressure (mean square), P and growth."""
    return {
        "pressure_off": float(np.linalg.norm(pressure - its) / np.linalg.norm(its)),
        "P_off": row["P"] / exact["P"] - 1,
        "growth_off": row["growth"] - exact["growth"],
    }


def state(result: Result) -> tuple[Row, Floats]:
    """Return a run as a row, and its contact pressure (N/m^2) at (RADII, ANGLES) points."""
    assert result.steady is not None
    law, pad = result.scene.contacts[CONTACT].law, result.scene.bodies[PAD].geometry
    assert law is not None
    assert isinstance(pad, Crowned)
    steady = result.steady.contacts[CONTACT]
    weight = result.interfaces[CONTACT].points.weight
    closed = closures(result, common_points(pad))
    row = {
        "dofs": result.system.size,
        "points": len(weight),
        "closed": steady.closed_fraction,
        "force": steady.normal_force,
        "P": float(weight @ steady.stiffness),
        "growth": float(result.growth_rates.max(initial=0.0)),
        "unstable": int(np.sum(result.unstable)),
        "iterations": result.steady.iterations,
        "seconds": result.timer.total,
    }
    return row, law.pressure(closed).reshape(RADII, ANGLES)


def common_points(pad: Crowned) -> Floats:
    """Return midpoints of equal parts of the crowned face (m), radius by radius."""
    base = pad.base
    assert isinstance(base, Sector)
    return pad.crown(sector_points(base, RADII, ANGLES, base.bottom))


def closures(result: Result, x: Floats) -> Floats:
    """Return the closures u_n - g_n (m) of steady sliding at points (m) of the pad."""
    assert result.steady is not None
    bodies, system, displaced = result.system.bodies, result.system, result.steady.displacement
    pad, disc = bodies[PAD].surfaces["bottom"], bodies[DISC].surfaces["top"]
    up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    own = pad.locate(x, up, pad.mesh_size)
    normal = pad.normal(own.at)
    opposite = disc.locate(x + own.distance[:, None] * up, normal, disc.mesh_size)
    if own.missed.any() or opposite.missed.any():
        raise InputError("x", f"{len(x)} points", "points between both sides of the contact")
    moved = pad.trace(own.at) @ system.displacement(displaced, PAD).reshape(-1, 3)
    moved -= disc.trace(opposite.at) @ system.displacement(displaced, DISC).reshape(-1, 3)
    gap = opposite.distance + disc.offset(opposite.at, normal) - pad.offset(own.at, normal)
    return np.einsum("ij,ij->i", normal, moved) - gap


CROWNED_PAD = CrownedPad("crowned", "Steady sliding of a crowned pad by formulation")  # the study
