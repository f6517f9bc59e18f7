"""Warnings of records of many runs: those of the runs, merged, in tables and on screen."""

import numpy as np
import pytest
from sweep_cases import P, sine_blocks

from comparisons.study.run_warnings import kinds_at
from comparisons.sweep.page import read_sweep
from comparisons.sweep.points import read_axis
from comparisons.sweep.scene import mapped
from scenes import load_scene, run_modes

STIFFNESS = "contacts.interface.p"


@pytest.fixture
def changes(backend):
    """Layers of which one reaches beyond the other; points are too crude where p is small."""
    method = {"fe": "node_to_surface", "iga": "greville"}[backend]
    return sine_blocks(
        backend,
        "bodies.upper.geometry.origin=[1.0, 0.0]",
        "contacts.interface.max_missed=0.6",
        "contacts.interface.mu=0.1",
        f"contacts.interface.formulation={{method='{method}'}}",
        "analysis.max_frequency=0.3",
    )


def kinds(warnings):
    return sorted(warning.kind for warning in warnings)


@pytest.mark.grid(quick=1)
def test_a_sweep_warns_of_what_its_runs_warn_of(changes, cea, tmp_path):
    """Of a rule too crude where the contact is soft, of what is uncovered everywhere."""
    given = [word for each in changes for word in ("--set", each)]
    code, told, fault = cea(
        "sweep", "blocks", f"{STIFFNESS}=1:1e3:2", "--full", "--out", ".", *given
    )
    assert not code, fault
    scene = load_scene("blocks", changes)
    fresh = {v: run_modes(scene.change(STIFFNESS, v)).warnings for v in (1.0, 1e3)}
    assert set(kinds(fresh[1.0])) != set(kinds(fresh[1e3]))
    screen, warnings = " ".join(told.split()), read_sweep(tmp_path).record["warnings"]
    for value, own in fresh.items():
        assert sorted(kinds_at(warnings, {STIFFNESS: value})) == kinds(own)
    for warning in warnings:
        assert screen.count(f"warning ({warning['kind']}): {warning['message']}") == 1
    merged = {each["kind"]: each for each in warnings}
    assert len(merged) == len(warnings)
    uncovered, crude = merged["partly-uncovered"], merged["point-rule"]
    assert uncovered["message"].endswith(f"(at all 2 values of {STIFFNESS})")
    assert crude["message"].endswith(f"(at 1 of 2 values of {STIFFNESS}: {STIFFNESS} = 1)")
    given = [dict(w.data) for w in fresh[1.0] if w.kind == "point-rule"]
    assert [place["data"] for place in crude["data"]["places"]] == given
    assert "partly-uncovered" in (tmp_path / "sweep.csv").read_text()


@pytest.mark.grid(quick=1)
def test_full_solves_of_a_map_warn_as_runs_do(changes):
    """At the stiffness there, also where p varies over the contact."""
    scene = mapped("blocks", [read_axis(f"{P}=1:2:2")], (*changes, f"{STIFFNESS}='1 + x'"), None)
    own = scene.pencil.parameters[P].value
    for value in (1.0, 2.0):
        modes = scene.driver.solve(scene.window.max_frequency, {P: value})
        warnings = scene.warnings(modes, {P: value})
        there = load_scene("blocks", changes).change(STIFFNESS, f"{value / own}*(1 + x)")
        fresh = run_modes(there)
        assert kinds(warnings) == kinds(fresh.warnings)
        for found, expected in zip(warnings, fresh.warnings, strict=True):
            for name, number in expected.data.items():
                if isinstance(number, float) and np.isfinite(number):
                    assert found.data[name] == pytest.approx(number, rel=1e-8)
    scene.driver.free()
