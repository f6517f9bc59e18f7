"""Bodies of simple shapes under supports in local frames."""

from blocks import ROTATED, alone, section

from cea.eigen.driver import solve_modes
from cea.eigen.pencil import Pencil
from cea.material import IsotropicMaterial
from cea.timing import StageTimer
from meshes.placement import Placement
from scenes.building.build import build_bodies
from scenes.spec.reading import read_scene

MATERIAL = IsotropicMaterial(E=2.0, nu=0.3, rho=1.5)
BOX = {"shape": "box", "size": [1.0, 0.7, 0.4]}
RING = {"shape": "annulus", "inner_radius": 0.8, "outer_radius": 1.6, "bottom": 0.0, "top": 0.2}
QUARTER = {**RING, "shape": "sector", "start": 0.0, "end": 90.0}
PLACED = Placement(tuple(ROTATED["axis"]), ROTATED["angle"], tuple(ROTATED["translation"]))
ABOUT_Z = {"axis": [0.0, 0.0, 1.0]}
ABOUT_PLACED = {"axis": PLACED.rotation[:, 2].tolist(), "origin": ROTATED["translation"]}


def build(backend, geometry, supports, elements, *, pressures=(), **options):
    """A body as scenes say it."""
    scene = alone(section(backend, geometry, elements, supports=supports, **options))
    scene["loads"] = [{"surface": f"part.{name}", "pressure": p} for name, p in pressures]
    return build_bodies(read_scene(scene), StageTimer())["part"]


def on(names, component="normal", **frame):
    """One component held on each of several surfaces."""
    return [{"surface": name, "components": [component], **frame} for name in names]


def eigenvalues(body, max_frequency):
    """Squares of the angular frequencies."""
    modes = solve_modes(Pencil.of(body.stiffness(), body.mass()), max_frequency)
    return modes.eigenvalues.imag**2
