"""Sweeps of contacts that are stiff, or tied, beside fresh runs."""

from pathlib import Path

import pytest
from sweep_cases import COARSE_DISC, assert_within_bounds, sweep_of

from scenes import run_modes
from scenes.spec.reading import load_scene

SCENE = Path(__file__).parent.parent / "data" / "sweeps" / "bonded.toml"
TIED = "contacts.tie.P=inf"


def swept(backend, axis, out, *overrides):
    """A sweep, and its scene."""
    bodies = (f"bodies.{name}.backend='{backend}'" for name in ("base", "mid", "cap"))
    overrides = (*bodies, *overrides)
    made = sweep_of(SCENE, [axis], out / "out", overrides, checks=1, confirm=9)
    return made, load_scene(SCENE, overrides)


@pytest.mark.parametrize(
    ("axis", "overrides"),
    [
        ("contacts.tie.P=1e-1:1e13:log:8", ()),
        ("contacts.low.P=1e-1:1e13:log:8", ()),
        ("contacts.low.P=1e-1:1e6:log:6", (TIED,)),
        ("contacts.low.mu=0:0.8:6", (TIED,)),
    ],
)
def test_fresh_runs_lie_within_the_bounds_of_stiff_and_tied_contacts(
    tmp_path, backend, axis, overrides
):
    made, scene = swept(backend, axis, tmp_path, *overrides)
    assert made.record["certified"] == made.record["values"]
    assert made.spectra.bound.max() < 1e-6
    for i, value in enumerate(made.record["axes"][0]["values"]):
        modes = run_modes(scene.change(axis.partition("=")[0], value)).modes
        rows, _ = assert_within_bounds(made, i, modes)
        assert len(rows) == len(modes.eigenvalues)


@pytest.mark.slow
def test_a_map_is_certified_up_to_any_stiffness(tmp_path):
    """In the penalty form rounding leaves bounds of 1e-7 from P = 1e13 on."""
    axes, options = ("mu=0:1:3", "P=1e12:1e14:log:3"), {"checks": 1, "confirm": 0}
    made = sweep_of("disc_pad", axes, tmp_path / "out", COARSE_DISC, **options)
    assert made.record["certified"] == 9
    scene = load_scene("disc_pad", COARSE_DISC)
    for i in (4, 8):
        point = dict(zip(("mu", "P"), made.points.values[i], strict=True))
        changes = {f"contacts.pad_disc.{name}": value for name, value in point.items()}
        assert_within_bounds(made, i, run_modes(scene.change(changes)).modes)


def test_tied_contacts_have_thresholds(tmp_path):
    made, scene = swept("fe", "contacts.low.P=1e-1:1e6:log:8", tmp_path, TIED)
    assert made.record["thresholds"]
    assert not made.record["unresolved"]
    for each in made.record["thresholds"]:
        assert abs(each["full_solve_differs"]) <= each["error"] + 1e-9 * each["value"]
        change = 0
        for way in (-1, 1):
            at = run_modes(scene.change("contacts.low.P", each["value"] * (1 + way * 1e-6)))
            change += way * (at.growth_rates > 10 * at.modes.growth_uncertainties).sum()
        assert change * 2 == each["change"] or each["kind"] != "flutter"
