"""Warnings of records of many runs: those of the runs, merged, in tables and on screen."""

import numpy as np
import pytest
from blocks import rectangle

from comparisons.study.run_warnings import kinds_at
from comparisons.sweep.page import read_sweep
from comparisons.sweep.points import read_axis
from comparisons.sweep.scene import mapped
from scenes import load_scene, read_scene, run_modes
from scenes.spec.plain import scene_text

STIFFNESS = "contacts.sliding.p"


@pytest.fixture
def file(backend, tmp_path):
    """A pad that reaches beyond the bar it slides on; points are too crude where p is small."""
    material = {"E": 1e10, "nu": 0.3, "rho": 2500.0}
    pad = rectangle(backend, [0.04, 0.01], [3, 1], origin=[0.0, 0.01], material=material)
    bar = rectangle(backend, [0.125, 0.01], [3, 1], origin=[-0.1, 0.0], material=material)
    sliding = {
        "a": "pad.y_min",
        "b": "bar.y_max",
        "formulation": {"method": {"fe": "node_to_surface", "iga": "greville"}[backend]},
        "p": 1e12,
        "mu": 0.4,
        "friction_direction_on_a": {"vector": [1.0, 0.0]},
        "max_missed": 0.5,
    }
    scene = {
        "name": "overhang",
        "bodies": {"pad": pad, "bar": bar | {"supports": [{"surface": "y_min"}]}},
        "contacts": {"sliding": sliding},
        "analysis": {"kind": "cea", "max_frequency": 20000.0},
    }
    path = tmp_path / "overhang.toml"
    path.write_text(scene_text(read_scene(scene)))
    return path


def kinds(warnings):
    return [warning.kind for warning in warnings]


@pytest.mark.grid(quick=1)
def test_a_sweep_warns_of_what_its_runs_warn_of(file, cea, tmp_path):
    """Of a rule too crude where the contact is soft, of what is uncovered everywhere."""
    code, told, _ = cea("sweep", file, f"{STIFFNESS}=1e11:1e15:2", "--full", "--out", "out")
    assert not code
    fresh = {v: run_modes(load_scene(file).change(STIFFNESS, v)).warnings for v in (1e11, 1e15)}
    assert set(kinds(fresh[1e11])) != set(kinds(fresh[1e15]))
    out, screen = tmp_path / "out", " ".join(told.split())
    warnings = read_sweep(out).record["warnings"]
    for value, own in fresh.items():
        assert kinds_at(warnings, {STIFFNESS: value}) == kinds(own)
    for warning in warnings:
        assert screen.count(f"warning ({warning['kind']}): {warning['message']}") == 1
    merged = {each["kind"]: each for each in warnings}
    assert len(merged) == len(warnings)
    uncovered, crude = merged["partly-uncovered"], merged["point-rule"]
    assert uncovered["message"].endswith(f"(at all 2 values of {STIFFNESS})")
    assert crude["message"].endswith(f"(at 1 of 2 values of {STIFFNESS}: {STIFFNESS} = 1e+11)")
    given = [dict(w.data) for w in fresh[1e11] if w.kind == "point-rule"]
    assert [place["data"] for place in crude["data"]["places"]] == given
    assert "partly-uncovered" in (out / "sweep.csv").read_text()


@pytest.mark.grid(quick=1)
def test_full_solves_of_a_map_warn_as_runs_do(file):
    """At the stiffness there, also where p varies over the contact."""
    p, P = f"{STIFFNESS}='1e11*(1 + x)'", "contacts.sliding.P"
    scene = mapped(file, [read_axis(f"{P}=3e9:6e9:2")], [p], None)
    own = scene.pencil.parameters[P].value
    for value in (3e9, 6e9):
        modes = scene.driver.solve(scene.window.max_frequency, {P: value})
        warnings = scene.warnings(modes, {P: value})
        fresh = run_modes(load_scene(file).change(STIFFNESS, f"{value / own}*1e11*(1 + x)"))
        assert kinds(warnings) == kinds(fresh.warnings)
        for found, expected in zip(warnings, fresh.warnings, strict=True):
            for name, number in expected.data.items():
                if isinstance(number, float) and np.isfinite(number):
                    assert found.data[name] == pytest.approx(number, rel=1e-8)
    scene.driver.free()
