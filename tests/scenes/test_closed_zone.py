"""Closed zones that end inside a contact need elements across, the more the stiffer the law."""

import numpy as np
import pytest
from blocks import rectangle

from scenes import read_scene, run_modes
from scenes.checking.equilibrium import closed_zone

SEGMENTS = {"method": "segments"}


def crowned_pad(backend, refined, c_n, formulation=SEGMENTS, **analysis):
    """A crowned pad on a bar, with friction; the closed zone is half as wide as the pad."""
    sides = [{"surface": name, "components": ["x"]} for name in ("x_min", "x_max")]
    soft, hard = ({"E": E, "nu": 0.3, "rho": 2500.0} for E in (5e9, 1e10))
    pad = rectangle(backend, [0.04, 0.02], [8 * refined, 3], origin=[0.0, 0.02], material=soft)
    crown = {"shape": "crowned", "base": pad["geometry"], "surface": "y_min", "radii": {"x": 8.0}}
    bar = rectangle(backend, [0.1, 0.02], [13 * refined, 2], origin=[-0.03, 0.0], material=hard)
    bodies = {
        "pad": pad | {"geometry": crown, "supports": sides},
        "bar": bar | {"supports": [{"surface": "y_min"}]},
    }
    contact = {"a": "pad.y_min", "b": "bar.y_max", "formulation": formulation, "reach": 1e-4}
    contact |= {"c_n": c_n, "m_n": 1.5, "mu": 0.4, "friction_direction_on_a": {"vector": [1, 0]}}
    return read_scene(
        {
            "name": "crowned",
            "bodies": bodies,
            "contacts": {"s": contact},
            "loads": [{"surface": "pad.y_max", "pressure": 1e6}],
            "analysis": {"kind": "cea", "max_frequency": 12000.0} | analysis,
        }
    )


def told(result):
    return [w.data for w in result.warnings if w.kind == "coarse-closed-zone"]


@pytest.mark.parametrize("shape", ["disc", "strip", "annulus"])
def test_the_width_of_a_zone_in_space(shape):
    """That of the largest circle in it: diameter, breadth, difference of the radii."""
    grid = np.meshgrid(np.linspace(-1, 1, 401), np.linspace(-1, 1, 401))
    x = np.column_stack([*(g.ravel() for g in grid), np.full(401**2, 0.7)])
    r = np.hypot(x[:, 0], x[:, 1])
    closure = {"disc": 0.4 - r, "strip": 0.2 - np.abs(x[:, 0]),
               "annulus": 0.15 - np.abs(r - 0.6)}[shape]  # fmt: skip
    found = closed_zone(x, closure)
    assert found.width == pytest.approx(
        {"disc": 0.8, "strip": 0.4, "annulus": 0.3}[shape], abs=0.02
    )
    if shape == "strip":
        assert np.abs(found.across) == pytest.approx([1, 0, 0])


@pytest.mark.grid
@pytest.mark.parametrize("formulation", [SEGMENTS, {"method": "mortar"}])
def test_too_few_elements_for_a_stiff_law_are_told(formulation, backend):
    """The finer mesh knows of an unstable mode that the coarse one of splines does not."""
    coarse, fine = (
        run_modes(crowned_pad(backend, refined, 1e19, formulation)) for refined in (1, 3)
    )
    (data,) = told(coarse)
    assert data["contact"] == "s"
    assert data["elements"] < data["needed"]
    assert data["width"] == pytest.approx(
        0.04 * coarse.steady.contacts["s"].closed_fraction, rel=0.5
    )
    assert told(fine) == []
    assert fine.growth_rates.max() > 2500
    if backend == "iga":
        assert coarse.verdict == "stable"
