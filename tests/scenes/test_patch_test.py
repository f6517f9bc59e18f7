"""The contact patch test: numbers of an independent prototype, and what must hold anywhere."""

from pathlib import Path

import pytest

from cea.contact.formulations import GaussPointToSurface, Greville, Grid, NodeToSurface
from scenes import run_scene
from scenes.spec.reading import load_scene, on_backend, with_contact


def stresses(backend, formulation, P):
    scene = with_contact(
        on_backend(load_scene(Path("patch_test")), backend), formulation=formulation, P=P
    )
    return run_scene(scene).stresses["interface"]


@pytest.mark.parametrize(
    ("formulation", "P", "side", "expected"),
    [
        (Greville(), 1e14, None, 1722.0),
        (Greville(), 1e6, None, 3233.0),
        (Grid(9), 1e6, None, 1678.0),
        (GaussPointToSurface(15), 1e6, "b", 0.446),
        (GaussPointToSurface(15), 1e6, "a", 0.0339),
        (GaussPointToSurface(25), 1e6, None, 0.116),
    ],
)
def test_nurbs_oscillation_matches_the_prototype(formulation, P, side, expected):
    sides = stresses("iga", formulation, P)
    found = sides[side].oscillation if side else max(s.oscillation for s in sides.values())
    assert found == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(("backend", "collocation"), [("fe", NodeToSurface()), ("iga", Greville())])
def test_mean_stress_balances_the_load(backend, collocation):
    """Whatever the oscillation, the pressure arrives."""
    for side in stresses(backend, GaussPointToSurface(15), 1e6).values():
        assert side.sigma_n.mean() == pytest.approx(-1000.0, rel=1e-3)
    oscillation = max(s.oscillation for s in stresses(backend, collocation, 1e6).values())
    assert oscillation > 100
