"""Thresholds of flutter against damping: elastic bodies over the exact lumped system."""

import pytest

from comparisons.damping import MODULUS, STUDY, Options, dampings, evaluate, exact, scene
from comparisons.study.session import Session


def threshold(backend, share, ratio):
    session = Session(Options())
    case = {"backend": backend, "share": share, "ratio": ratio}
    session.begin(scene(case, Options()))
    return evaluate(case, session)["threshold"]


def test_dampings_have_their_mean_and_their_share():
    c1, c2 = dampings(3.0, 0.02)
    first, second = c1 / 2, c2 / 2 / 1.2
    assert second / first == pytest.approx(3.0)
    assert (first + second) / 2 == pytest.approx(0.02)


@pytest.mark.grid(quick=1)
def test_elastic_bodies_flutter_where_the_lumped_system_does(backend):
    """Up to terms of the order k / E; damped so unlike that half of the friction suffices."""
    found = threshold(backend, 10.0, 0.01)
    assert found == pytest.approx(exact(10.0, 0.01), rel=1 / MODULUS)
    assert found == pytest.approx(0.098287, abs=1e-6)
    assert found < 0.6 * exact(1.0, 0.0)


def test_damping_moves_thresholds_both_ways():
    undamped = exact(1.0, 0.0)
    assert undamped == pytest.approx(0.44 / 2.4)
    assert exact(1.0, 0.1) > undamped > exact(10.0, 0.1)
    assert len(list(STUDY.cases(Options()))) == 48
