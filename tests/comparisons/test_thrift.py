"""When a sweep gives its basis up, and what it tells then."""

import json
import sys

import pytest

from cea.petsc import MPI
from comparisons.cli.app import main
from comparisons.sweep import thrift
from comparisons.sweep.thrift import BasisTooDearError, Thrift

GOAL = 5e-9


def weighed(values, bounds, *, full=10.0, basis=10.0, value=0.1, plain=8.0):
    """Weigh a basis at bounds, one before each of its solves but the first; how often was timed."""
    timed = []
    made = Thrift(values, GOAL, 2, lambda: timed.append(1) or plain)
    made.weigh(float("inf"), 0, 0.0, 0.0, 0.0)
    for solves, bound in enumerate(bounds, 1):
        made.weigh(bound, solves, solves * full, solves * basis, value)
    return len(timed)


def test_a_basis_for_many_values_is_never_in_doubt():
    assert weighed(101, [1e3, 1e-4, 1e-6]) == 0


def test_a_basis_for_few_values_is_given_up_at_once():
    """Four more solves and two checks of 20 s each, against five of 8 s."""
    with pytest.raises(BasisTooDearError, match="5 full solves take about 40 s"):
        weighed(5, [1e3])


def test_where_it_is_open_one_full_solve_is_timed_and_no_more():
    assert weighed(25, [1e3, 1e-2, 1e-5, 1e-7], plain=8.0) == 1


def test_a_basis_whose_bounds_stand_still_is_given_up():
    with pytest.raises(BasisTooDearError):
        weighed(25, [1e-3, 9e-4, 8e-4, 7e-4], plain=8.0)


def test_values_on_the_basis_count_too():
    with pytest.raises(BasisTooDearError):
        weighed(101, [1e-8], value=40.0)


def test_little_to_be_saved_is_not_worth_what_a_map_tells_more():
    assert weighed(3, [1e3], full=0.5, basis=0.5, plain=0.2) == 0


@pytest.mark.slow
def test_the_command_tells_that_it_solved_in_full_and_why(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(thrift, "_WORTH", -1e6)
    window = "analysis.max_frequency=0.3"
    folders = {"": tmp_path / "chosen", "--basis": tmp_path / "basis"}
    for option, out in folders.items():
        words = [each for each in ("mu=0:2:3", option, "--set", window) if each]
        monkeypatch.setattr(sys, "argv", ["cea", "sweep", "blocks", *words, "--out", str(out)])
        with pytest.raises(SystemExit) as end:
            main()
        assert not end.value.code, capsys.readouterr().err
        told = " ".join(capsys.readouterr().out.split())
        assert ("Solved in full at each value: 3 full solves take about" in told) == (not option)
        assert not out.with_name(out.name + ".unfinished").exists()
    if MPI.COMM_WORLD.rank == 0:
        chosen, basis = (json.loads((out / "result.json").read_text()) for out in folders.values())
        assert "a basis for them would take" in chosen["why"]
        assert len(chosen["points"]) == 3
        assert basis["certified"] == 3
