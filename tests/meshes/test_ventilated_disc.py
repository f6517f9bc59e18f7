"""The ventilated disc: volume and areas in closed form, names of surfaces, refusals."""

from dataclasses import replace
from math import asin, pi

import pytest
from gmsh_models import measures

from cea.errors import InputError
from meshes.shape_mesh import shape_mesh
from meshes.ventilated_disc import VentilatedDisc

DISC = VentilatedDisc()
OTHER = VentilatedDisc(
    holes=4, hole_radius=0.006, hole_start=7.0, vanes=13, vane_width=0.02, vane_start=11.0,
    upper_bottom=0.03, upper_top=0.042, hub_bottom=0.05, hub_top=0.058, ring_height=0.012,
)  # fmt: skip
ROUGH = 0.03
"""Edge length (m) for meshes of which only the geometry matters."""


def areas_of(disc):
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


@pytest.mark.parametrize(
    "disc",
    [pytest.param(DISC, marks=pytest.mark.slow, id="as built"), pytest.param(OTHER, id="another")],
)
def test_volume_and_areas_are_those_in_closed_form(disc):
    """Curved cells of second order miss circles by the fourth power of their length."""
    found, areas = measures(shape_mesh(disc, "tetrahedron", 2, size=ROUGH))
    assert found.sum() == pytest.approx(disc.volume, rel=1e-5)
    # Twelve arcs of second order round a hole are too short by (2 pi / 12)^4 / 1440.
    assert areas == pytest.approx(areas_of(disc), rel=6e-5)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("bore", 0.0),
        ("wall_inner", 0.03),
        ("outer_radius", 0.12),
        ("ring_height", -0.01),
        ("upper_bottom", 0.01),
        ("hub_top", 0.065),
        ("holes", -1),
        ("hole_radius", 0.031),
        ("hole_circle", 0.2),
        ("vanes", 0),
        ("vane_width", 0.038),
    ],
)
def test_what_cannot_be_built_is_refused(field, value):
    with pytest.raises(InputError) as caught:
        replace(DISC, **{field: value})
    assert caught.value.field == field
