"""Meshes of the shapes: nodes on circles, measures, names, refusals."""

from dataclasses import replace
from math import asin, pi

import gmsh
import numpy as np
import pytest
from covering import covering
from gmsh_models import assert_outer_facets_are_named, gmsh_model, measures
from iga_data import STEEL, body
from petsc_matrices import to_scipy

from cea.errors import InputError
from meshes.breaks import breaks_of
from meshes.placement import Placement
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Annulus, Box, Disc, Hub, Rectangle, Ring, RingSector, Sector
from meshes.ventilated_disc import VentilatedDisc

BOX = Box((0.3, 0.2, 0.1), origin=(-0.1, 0.05, 0.02))
ANNULUS = Annulus(0.06, 0.15, -0.002, 0.01)
SECTOR = Sector(0.1, 0.14, -25.0, 60.0, 0.0, 0.02)
RECTANGLE = Rectangle((0.3, 0.2), origin=(-0.1, 0.05))
HUB = Hub(0.2, 0.5, 1.0, 0.0, 0.2, -0.1, 0.4)
FLUSH_HUB = Hub(0.2, 0.5, 1.0, 0.0, 0.2, 0.0, 0.4)
DISC = Disc(1.0, 0.1, 0.3)
RING = Ring(0.5, 1.0)
RING_SECTOR = RingSector(0.5, 1.0, -25.0, 60.0)
VENTILATED = VentilatedDisc()
OTHER = VentilatedDisc(
    holes=2, hole_radius=0.006, hole_start=7.0, vanes=3, vane_width=0.02, vane_start=11.0,
    upper_bottom=0.03, upper_top=0.042, hub_bottom=0.05, hub_top=0.058, ring_height=0.012,
)  # fmt: skip
PLACEMENT = Placement(axis=(1.0, -2.0, 0.5), angle=50.0, translation=(0.3, 0.1, -0.7))


BREAKS = breaks_of(BOX, (1, 1, 1))
HALVES = tuple(map(np.array, ([0.06, 0.15], [0.0, 180.0, 360.0], [-0.002, 0.01])))


@pytest.mark.parametrize(
    ("field", "arguments", "keywords"),
    [
        ("breaks of r", (DISC, "hexahedron", 1), {"breaks": breaks_of(DISC, (1, 4, 1))}),
        ("breaks", (BOX, "hexahedron", 1), {}),
        ("breaks of x", (BOX, "hexahedron", 1), {"breaks": (BREAKS[0][::-1], *BREAKS[1:])}),
        ("breaks of y", (BOX, "hexahedron", 1), {"breaks": (BREAKS[0], 2 * BREAKS[1], BREAKS[2])}),
        ("breaks of theta", (ANNULUS, "hexahedron", 1), {"breaks": HALVES}),
    ],
)
def test_wrong_input_is_refused_by_name(field, arguments, keywords):
    with pytest.raises(InputError) as refused:
        shape_mesh(*arguments, **keywords)
    assert refused.value.field == field
    assert not gmsh.isInitialized()


def of_hub(hub):
    """Volume and areas of a hub."""
    ring = np.pi * (hub.outer_radius**2 - hub.hub_radius**2)
    end = np.pi * (hub.hub_radius**2 - hub.bore**2)
    through, thickness = hub.hub_top - hub.hub_bottom, hub.top - hub.bottom
    return end * through + ring * thickness, {
        "bore": 2 * np.pi * hub.bore * through,
        "outer": 2 * np.pi * hub.outer_radius * thickness,
        "bottom": ring,
        "top": ring,
        "hub_bottom": end,
        "hub_top": end,
        "hub_side": 2 * np.pi * hub.hub_radius * (through - thickness),
    }


def of_round(shape, height=1.0):
    """Volume and areas of a ring or a part of it; of one in the plane they are per length."""
    inner, outer = shape.extent[0]
    angle = np.radians(np.ptp(shape.extent[1]))
    face, side = angle * (outer**2 - inner**2) / 2, (outer - inner) * height
    areas = {"inner": angle * inner * height, "outer": angle * outer * height, "start": side}
    areas |= {"end": side, "bottom": face, "top": face}
    return face * height, {name: areas[name] for name in shape.surfaces}


BOX_AREAS = {"x_min": 0.02, "x_max": 0.02, "y_min": 0.03, "y_max": 0.03, "z_min": 0.06}
SIDES = {"x_min": 0.2, "x_max": 0.2, "y_min": 0.3, "y_max": 0.3}
MEASURES = {
    "box": (BOX, 0.006, BOX_AREAS | {"z_max": 0.06}),
    "annulus": (ANNULUS, *of_round(ANNULUS, 0.012)),
    "sector": (SECTOR, *of_round(SECTOR, 0.02)),
    "hub": (HUB, *of_hub(HUB)),
    "flush hub": (FLUSH_HUB, *of_hub(FLUSH_HUB)),
    "disc": (DISC, *of_round(DISC, 0.2)),
    "rectangle": (RECTANGLE, 0.06, SIDES),
    "ring": (RING, *of_round(RING)),
    "ring sector": (RING_SECTOR, *of_round(RING_SECTOR)),
}
KINDS = ("boxes", "divided boxes", "unstructured")


@pytest.mark.parametrize(("name", "order", "kind"), covering(tuple(MEASURES), (1, 2, 3, 4), KINDS))
def test_shapes_have_their_volume_and_the_areas_of_their_surfaces(name, order, kind):
    shape, volume, areas = MEASURES[name]
    dim = len(shape.directions)
    cells = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}[dim]
    mesh = {"breaks": breaks_of(shape, (3, 12, 4)[:dim])}
    if kind == "unstructured":
        mesh = {"size": 0.2 if name not in ("box", "annulus", "sector") else 0.03}
    place = PLACEMENT if dim == 3 else Placement(angle=50.0)
    rel = {1: 5e-2, 2: 2e-3, 3: 5e-4, 4: 5e-6}[order]
    made = shape_mesh(shape, cells[kind != "boxes"], order, placement=place, **mesh)
    assert_outer_facets_are_named(made)
    found, found_areas = measures(made)
    assert found.sum() == pytest.approx(volume, rel=rel)
    assert found_areas == pytest.approx(areas, rel=rel)


SIMILAR = ("annulus", "flush hub")
"""Shapes that differ little from others."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name in SIMILAR else ()) for name in MEASURES],
)
def test_patches_of_shapes_have_them_exactly(name):
    shape, volume, areas = MEASURES[name]
    dim = len(shape.directions)
    part = body(shape, (3, 16, 3)[:dim], (2, 5, 2)[:dim])
    assert to_scipy(part.mass()).sum() == pytest.approx(dim * STEEL.rho * volume, rel=1e-13)
    assert {n: each.area for n, each in part.surfaces.items()} == pytest.approx(areas, rel=1e-13)
    assert len(np.unique(np.round(part.space.dof_positions, 9), axis=0)) == part.num_scalar_dofs


def areas_of_ventilated(disc):
    """Areas of the named surfaces in closed form (m^2)."""
    holes = disc.holes * pi * disc.hole_radius**2
    outer, plate = disc.outer_radius, disc.hub_top - disc.hub_bottom
    rings = disc.ring_height + disc.upper_top - disc.upper_bottom
    ends = disc.vanes * 2 * outer * asin(disc.vane_width / 2 / outer)
    return {
        "bore": 2 * pi * disc.bore * plate,
        "holes": disc.holes * 2 * pi * disc.hole_radius * plate,
        "lower_face": pi * (outer**2 - disc.wall_inner**2),
        "upper_face": pi * (outer**2 - disc.flange_outer**2),
        "rim": 2 * pi * outer * rings + ends * (disc.upper_bottom - disc.ring_height),
        "hub_top": pi * (disc.wall_outer**2 - disc.bore**2) - holes,
    }


@pytest.mark.parametrize("disc", [pytest.param(VENTILATED, marks=pytest.mark.slow), OTHER])
def test_ventilated_discs_have_their_volume_and_areas(disc):
    """Curved cells of second order miss circles by the fourth power of their length."""
    found, areas = measures(shape_mesh(disc, "tetrahedron", 2, size=0.03))
    assert found.sum() == pytest.approx(disc.volume, rel=1e-5)
    # Twelve arcs of second order round a hole are too short by (2 pi / 12)^4 / 1440.
    assert areas == pytest.approx(areas_of_ventilated(disc), rel=6e-5)


@pytest.mark.parametrize(
    ("field", "value"), [("bore", 0.0), ("hole_radius", 0.031), ("vanes", 0), ("vane_width", 0.038)]
)
def test_ventilated_discs_that_cannot_be_are_refused(field, value):
    with pytest.raises(InputError) as caught:
        replace(VENTILATED, **{field: value})
    assert caught.value.field == field


@pytest.mark.parametrize("order", [2, 3, 4])
def test_arcs_are_exact_at_lobatto_points(order):
    """The polynomial through the nodes of each arc meets the circle where it should."""
    inner = {
        2: [0.0],
        3: [-np.sqrt(1 / 5), np.sqrt(1 / 5)],
        4: [-np.sqrt(3 / 7), 0.0, np.sqrt(3 / 7)],
    }
    xi = np.array([[t, 0.0, 0.0] for t in [-1.0, 1.0, *inner[order]]])
    for cell in ("triangle", "quadrilateral"):
        mesh = {"size": 0.4} if cell == "triangle" else {"breaks": breaks_of(RING, (1, 12))}
        with gmsh_model(shape_mesh(RING, cell, order, **mesh)) as model:
            for radius, (_, tag) in zip((0.5, 1.0), model.getPhysicalGroups(1), strict=True):
                (entity,) = model.getEntitiesForPhysicalGroup(1, tag)
                kind = model.mesh.getElementTypes(1, entity)[0]
                points = model.mesh.getJacobians(kind, xi.ravel(), entity)[2].reshape(-1, 3)
                np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), radius, rtol=1e-13)
