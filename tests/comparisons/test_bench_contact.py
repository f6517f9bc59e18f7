"""Cost of one contact: every stage is timed, and time grows no faster than the points."""

import sys
from dataclasses import asdict

import pytest

from comparisons.bench.contact.cost import contact_cost
from comparisons.bench.contact.page import REPORT, costs_table, over_basis
from comparisons.cli.app import main
from comparisons.kit.numbers import number


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


def test_the_command_tells_every_mesh_and_draws_it_again(tmp_path, monkeypatch, capsys):
    command = ["cea", "bench", "contact", "--out", str(tmp_path)]
    for more in (["--elements", "4", "--elements", "8", "--repeats", "2"], ["--redraw"]):
        monkeypatch.setattr(sys, "argv", [*command, *more])
        with pytest.raises(SystemExit) as end:
            main()
        assert not end.value.code
        assert f"at {number(1024)} points" in capsys.readouterr().out
    data = REPORT.read(tmp_path)
    assert [(run["backend"], len(run["costs"])) for run in data["runs"]] == 2 * [
        ("fe", 2),
        ("iga", 2),
    ]
    assert [row[1] for row in costs_table(data).rows] == [256, 256, 1024, 1024]
    cost = {"basis": 2.0, "search": 3.0, "assembly": 5.0}
    assert over_basis({"costs": [cost]}) == 4.0
    assert "over basis" in (tmp_path / "report.md").read_text()
