"""Cost of one contact: every stage is timed, and time grows no faster than the points."""

from dataclasses import asdict

import pytest

from comparisons.bench.contact import contact_cost


@pytest.mark.parametrize("method", ["gpts", "mortar"])
def test_every_stage_is_timed(backend, method):
    rule = {"method": method} | ({"points": 2} if method == "gpts" else {})
    cost = asdict(contact_cost(backend, 10, rule))
    points = cost.pop("points")
    assert points >= {"gpts": 4 * 10**2, "mortar": 9 * 18**2}[method]
    assert all(seconds > 0 for seconds in cost.values())


@pytest.mark.slow
def test_time_is_linear_in_points(backend):
    """Ten times the points take less than twenty times the time: squared it would be a hundred."""
    few, many = (contact_cost(backend, n) for n in (40, 126))
    assert 9.5 < many.points / few.points < 10.5
    for stage in ("rule", "search", "assembly"):
        assert getattr(many, stage) < 20 * max(getattr(few, stage), 0.02), stage
