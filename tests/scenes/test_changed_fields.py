"""Every field of a scene, changed after it was assembled: as in a fresh run, or refused."""

from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np
import pytest
from changed_scenes import SCENES, scene_of

from cea.errors import InputError
from scenes import assemble, run_modes
from scenes.spec.plain import plain_data
from scenes.spec.problems import SceneError

UPPER, LOWER, CONTACT = "bodies.upper", "bodies.lower", "contacts.interface"
INNER = "bodies.inner"
DISC = "bodies.disc"


@dataclass(frozen=True)
class Row:
    """A change of an assembled scene, and what was changed before it was assembled."""

    scene: str
    changes: dict[str, Any]
    before: dict[str, Any] = field(default_factory=dict)
    backend: str | None = None  # of all bodies; left out, rows have them by turns
    refused: bool = False  # by a fresh run too


def of(section, **values):
    """Fields of a section of a scene by their paths."""
    return {f"{section}.{name}": value for name, value in values.items()}


SECOND = {"surface": "x_max", "components": ["x"]}
ROWS = [
    # the scene, its analysis, what is written of it
    Row("linear", {"name": "another", "description": "in other words", "units": "other"}),
    Row("linear", {"output.pictures": 2, "output.paraview": 1}),
    Row("linear", {"analysis.max_frequency": 0.6}),
    Row("rotating", {"analysis.min_growth": -0.01}),
    Row("linear", {"analysis": {"kind": "static"}}, refused=True),
    Row("linear", {"bodies.third": SCENES["linear"]("fe")["bodies"]["lower"]}, backend="fe"),
    # materials, alone and as far as stiffness reaches the state of sliding or the forms of contacts
    Row("linear", {f"{UPPER}.material.E": 5.0, f"{LOWER}.material.rho": 2.5}),
    Row(
        "linear",
        {f"{UPPER}.material.E": 2e-3, f"{LOWER}.material.E": 1e5, f"{CONTACT}.P": 1e5},
        before={f"{UPPER}.springs.0.stiffness": [50.0, 50.0]},
    ),
    # shapes, places, meshes
    Row("linear", {f"{UPPER}.backend": "iga"}, backend="fe"),
    Row("pressed", {f"{UPPER}.geometry.origin": [0.25, 0.4]}),
    Row("linear", {f"{body}.placement": {"angle": 20.0} for body in (UPPER, LOWER)}),
    # supports, springs, loads
    Row("linear", {f"{LOWER}.supports": [{"surface": "y_min"}, SECOND]}),
    Row("pressed", {f"{LOWER}.supports.0.value": [2e-4, 0.0]}),
    Row("pressed", {f"{UPPER}.springs.0.stiffness": [1.0, 0.5]}),
    Row("linear", {"loads.0.pressure": 5e-3}),
    Row("pressed", {"loads.1.force": [0.0, -4e-3]}),
    # contacts
    Row("linear", {f"{CONTACT}.P": 7.0, f"{CONTACT}.mu": 0.1}),
    Row("linear", {f"{CONTACT}.P": inf}),
    Row("linear", {f"{CONTACT}.P": 5.0}, before={f"{CONTACT}.P": inf}),
    Row("linear", of(CONTACT, P=None, c_n=1e2, reach=0.05) | {"loads.0.surface": "upper.y_max"},
        before={f"{UPPER}.supports.0.components": ["x"]}),
    Row("linear", {f"{CONTACT}.mu": 0.0}),
    Row("linear", {f"{CONTACT}.mu": 0.4}, before={f"{CONTACT}.mu": 0.0}),
    Row("linear", {f"{CONTACT}.mu": 0.4}, before={f"{CONTACT}.mu": "0.4*x"}),
    Row("linear", {f"{CONTACT}.P": 5.0, f"{CONTACT}.mu": 0.2},
        before={f"{CONTACT}.full_pass": True, f"{CONTACT}.max_missed": 0.6}),
    Row("linear", {"contacts": {}}),
    # damping, rotation, sliding
    Row("linear", {f"{UPPER}.damping": {"alpha": 0.1}}),
    Row("rotating", of(f"{INNER}.damping", alpha=0.05, beta=0.0)),
    Row("damped", {f"{DISC}.damping.modal.ratio": 0.05}, backend="iga"),
    Row("rotating", {f"{INNER}.rotation.rate": 0.3}),
    Row("rotating", {f"{INNER}.rotation.convective_stiffness": False}),
    Row("rotating", {f"{CONTACT}.sliding.pressure": 0.05, f"{CONTACT}.sliding.mu_slope": -0.2}),
    Row("damped", {f"{CONTACT}.sliding.speed": 0.2}, backend="iga"),
]  # fmt: skip


ASSEMBLED = {}


def assembled_scene(row):
    """The scene of a row before it is changed, assembled once for all rows that have it."""
    key = row.scene, backend_of(row), repr(row.before)
    if key not in ASSEMBLED:
        ASSEMBLED[key] = assemble(scene_before(row))
    return ASSEMBLED[key]


def scene_before(row):
    return scene_of(row.scene, backend_of(row)).change(row.before)


def told(result):
    """Kinds of warnings, and what they are about."""
    texts = [[v for v in w.data.values() if isinstance(v, str)] for w in result.warnings]
    return sorted((w.kind, *about) for w, about in zip(result.warnings, texts, strict=True))


def assert_the_same(found, fresh):
    assert plain_data(found.scene) == plain_data(fresh.scene)
    assert found.skipped == fresh.skipped
    assert told(found) == told(fresh)
    assert found.verdict == fresh.verdict
    assert found.modes.window.complete == fresh.modes.window.complete
    assert len(found.eigenvalues) == len(fresh.eigenvalues)
    scale = np.abs(fresh.eigenvalues).max(initial=0.0)
    np.testing.assert_allclose(found.eigenvalues, fresh.eigenvalues, rtol=1e-9, atol=1e-9 * scale)
    assert found.reactions.keys() == fresh.reactions.keys()
    for name, forces in fresh.reactions.items():
        np.testing.assert_allclose(found.reactions[name], forces, rtol=1e-9, atol=1e-12)
    assert (found.steady is None) == (fresh.steady is None)
    if fresh.steady is not None:
        own, other = found.steady, fresh.steady
        assert [step.factor for step in own.path] == [step.factor for step in other.path]
        for name, state in other.contacts.items():
            for kind in ("closure", "pressure", "stiffness", "force_on_a", "closed_area"):
                expected = getattr(state, kind)
                size = np.abs(expected).max()
                np.testing.assert_allclose(
                    getattr(own.contacts[name], kind), expected, rtol=1e-9, atol=1e-9 * size
                )


def backend_of(row):
    return row.backend or ("fe", "iga")[ROWS.index(row) % 2]


def name_of(row):
    before = f", before {', '.join(row.before)}" if row.before else ""
    return f"{row.scene}-{backend_of(row)}: {', '.join(row.changes)}{before}"


@pytest.mark.parametrize("row", ROWS, ids=name_of)
def test_a_changed_field_gives_the_result_of_a_fresh_run(row):
    before, assembled = scene_before(row), assembled_scene(row)
    if row.refused:
        with pytest.raises((SceneError, InputError)):
            run_modes(before.change(row.changes))
        with pytest.raises((SceneError, InputError)):
            assembled.modes(row.changes)
        return
    changed = before.change(row.changes)
    assert plain_data(changed) != plain_data(before)
    assert_the_same(assembled.modes(row.changes), run_modes(changed))
