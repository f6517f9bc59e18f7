"""Sweeps of contacts that are stiff, or tied, beside fresh runs."""

from pathlib import Path

import numpy as np
import pytest

from cea.eigen.matching import assign
from comparisons.sweep.points import read_axis
from comparisons.sweep.study import Asked, run
from scenes import run_modes
from scenes.spec.reading import load_scene

SCENE = Path(__file__).parent.parent / "data" / "sweeps" / "bonded.toml"
TIED = "contacts.tie.P=inf"


def swept(backend, axis, out, *overrides):
    """Modes and the record of a sweep, and the scene."""
    bodies = (f"bodies.{name}.backend='{backend}'" for name in ("base", "mid", "cap"))
    overrides = (*bodies, *overrides)
    made = run(Asked(SCENE, (read_axis(axis),), overrides, checks=1, confirm=9), out / "out")
    return made.spectra, made.record, load_scene(SCENE, overrides)


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
    row, record, scene = swept(backend, axis, tmp_path, *overrides)
    field = axis.partition("=")[0]
    assert record["certified"] == record["values"]
    assert row.bound.max() < 1e-6
    for i, value in enumerate(record["axes"][0]["values"]):
        fresh = run_modes(scene.change(field, value))
        there = np.isfinite(row.growth[i])
        found = row.growth[i, there] + 2j * np.pi * row.frequency[i, there]
        assert len(found) == len(fresh.eigenvalues)
        one, other = assign(np.abs(found[:, None] - fresh.eigenvalues))
        doubts = row.uncertainty[i, there][one] + fresh.modes.growth_uncertainties[other]
        assert (np.abs(found[one] - fresh.eigenvalues[other]) <= doubts).all()


@pytest.mark.slow
def test_a_map_is_certified_up_to_any_stiffness(tmp_path):
    """In the penalty form rounding leaves bounds of 1e-7 from P = 1e13 on."""
    coarse = (
        "bodies.pad.mesh.iga.elements=[3,6,2]",
        "bodies.disc.mesh.iga.elements=[5,32,1]",
    )
    axes = (read_axis("mu=0:1:3"), read_axis("P=1e12:1e14:log:3"))
    made = run(Asked("disc_pad", axes, coarse, checks=1, confirm=0), tmp_path / "out")
    assert made.record["certified"] == 9
    scene = load_scene("disc_pad", coarse)
    for i in (4, 8):
        mu, stiffness = made.points.values[i]
        fresh = run_modes(
            scene.change({"contacts.pad_disc.mu": mu, "contacts.pad_disc.P": stiffness})
        )
        there = made.spectra.there[i]
        found = made.spectra.growth[i, there] + 2j * np.pi * made.spectra.frequency[i, there]
        one, other = assign(np.abs(found[:, None] - fresh.eigenvalues))
        doubts = made.spectra.uncertainty[i, there][one] + fresh.modes.growth_uncertainties[other]
        assert (np.abs(found[one] - fresh.eigenvalues[other]) <= doubts).all()


def test_tied_contacts_have_thresholds(tmp_path):
    _, record, scene = swept("fe", "contacts.low.P=1e-1:1e6:log:8", tmp_path, TIED)
    assert record["thresholds"]
    assert not record["unresolved"]
    for each in record["thresholds"]:
        assert abs(each["full_solve_differs"]) <= each["error"] + 1e-9 * each["value"]
        before, after = (
            run_modes(scene.change("contacts.low.P", each["value"] * (1 + way * 1e-6)))
            for way in (-1, 1)
        )
        change = sum(
            (r.growth_rates > 10 * r.modes.growth_uncertainties).sum() * w
            for r, w in ((before, -1), (after, 1))
        )
        assert change * 2 == each["change"] or each["kind"] != "flutter"
