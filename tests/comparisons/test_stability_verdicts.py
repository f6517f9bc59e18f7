"""Verdicts of stability on planted answers: right, wrong, warned, refused."""

from dataclasses import replace

import numpy as np
import pytest
from planted import SAID, TRUE, Planted, answer, verdict_of

from cea.errors import ConvergenceError, InputError
from comparisons.stability.parts.case import ACCURATE, HONEST, MESH, NONE, REFUSED, WARNED, Run
from comparisons.stability.parts.problems import StressAnswer
from comparisons.stability.parts.references import Reference
from comparisons.stability.parts.ways import ALONE
from comparisons.stability.verdicts import compared, judged


def test_a_right_answer_is_accurate():
    found = verdict_of(answer())
    assert (found["verdict"], found["met"], found["error"]) == ("accurate", True, 0)


def test_a_right_answer_with_a_warning_is_not_easy():
    found = verdict_of(answer(warnings=("locking",)))
    assert (found["verdict"], found["met"], found["says"]) == ("accurate", False, ["locking"])
    assert verdict_of(answer(warnings=("locking",)), warnings=("locking",))["met"]


def test_a_warning_that_may_come_excuses_no_error():
    wrong = answer(TRUE[:4] * (1 + 1e-4), warnings=("short-modes",))
    assert verdict_of(wrong, HONEST, warnings=MESH)["verdict"] == "WRONG"
    assert verdict_of(wrong, HONEST, warnings=NONE)["verdict"] == "warned"


@pytest.mark.parametrize(
    "wrong",
    [
        answer(TRUE[:4] * (1 + 1e-4)),
        answer(TRUE[[0, 2, 3]], SAID[1:]),
        answer([*TRUE[:4], 3.5j], [*SAID, "stable"]),
        answer([TRUE[0], *TRUE[:4]], ["stable", *SAID]),
    ],
    ids=["digits", "missing", "spurious", "twice"],
)
def test_a_wrong_answer_is_wrong_without_a_word_and_warned_with_one(wrong):
    assert verdict_of(wrong, HONEST)["verdict"] == "WRONG"
    assert not verdict_of(wrong, HONEST)["met"]
    said = verdict_of(replace(wrong, warnings=("residual",)), HONEST)
    assert (said["verdict"], said["met"]) == ("warned", True)
    assert not verdict_of(replace(wrong, warnings=("residual",)), ACCURATE)["met"]
    open_end = verdict_of(replace(wrong, complete=False, verdict="undecided"), HONEST)
    assert (open_end["verdict"], open_end["says"]) == (
        "warned",
        ["undecided", "window-not-complete"],
    )


def test_an_error_that_the_uncertainty_admits_is_warned():
    off = answer(TRUE[:4] * (1 + 1e-4), uncertainties=np.full(4, 1e-3))
    assert verdict_of(off, WARNED)["verdict"] == "warned"
    small = answer(TRUE[:4] * (1 + 1e-4), uncertainties=np.full(4, 1e-5))
    assert verdict_of(small, WARNED)["verdict"] == "WRONG"
    missing = answer(TRUE[[0, 2, 3]], SAID[1:], uncertainties=np.ones(3))
    assert verdict_of(missing, WARNED)["verdict"] == "WRONG"


@pytest.mark.parametrize(
    "verdicts",
    [
        ("stable", "stable", "stable", "stable"),
        ("unstable", "stable", "unstable", "stable"),
        ("stable", "stable", "unstable", "unstable"),
    ],
)
def test_a_false_claim_is_wrong_whatever_is_warned_of(verdicts):
    found = verdict_of(answer(verdicts=verdicts, warnings=("residual",)), HONEST)
    assert (found["verdict"], found["met"]) == ("WRONG", False)
    assert "called" in found["reason"]


def test_a_window_called_stable_with_a_growing_mode_missing_is_wrong():
    found = verdict_of(answer(TRUE[:2], SAID[:2], warnings=("window-not-complete",)), HONEST)
    assert found["verdict"] == "WRONG"
    assert "window called stable" in found["reason"]
    honest = answer(TRUE[:2], SAID[:2], complete=False, verdict="undecided")
    assert verdict_of(honest, HONEST)["verdict"] == "warned"


def test_a_mode_that_may_be_another_makes_no_false_claim():
    """One beyond the window grows; what stands nearest to it inside is far off, and warned of."""
    true = [1j, 2j, 0.2 + 4.5j, -0.2 + 4.5j, 8j]
    found = answer([1j, 2j, 3.8j], 3 * ("stable",), warnings=("residual",))
    assert verdict_of(found, HONEST, true)["verdict"] == "warned"
    assert verdict_of(answer([1j, 2j, 3.8j], 3 * ("stable",)), HONEST, true)["verdict"] == "WRONG"


def test_a_divergence_belongs_to_every_window():
    true = [5.0 + 0j, *TRUE]
    assert verdict_of(answer(), HONEST, true)["missing"] == 1
    found = answer([5.0 + 0j, *TRUE[:4]], ("unstable", *SAID))
    assert verdict_of(found, true=true)["verdict"] == "accurate"


def test_what_is_undecided_is_not_accurate_unless_it_may_be():
    shy = answer(verdicts=("stable", "undecided", "unstable", "stable"))
    assert verdict_of(shy, WARNED)["verdict"] == "warned"
    assert verdict_of(shy, WARNED)["met"]
    assert not verdict_of(shy)["met"]
    assert verdict_of(shy, warnings=("undecided",))["verdict"] == "accurate"


def test_rounding_of_rigid_motions_does_not_grow():
    true = [0j, 0j, *TRUE]
    values = [1e-7 + 0j, 1e-7j, *TRUE[:4]]
    right = answer(values, ("stable", "stable", *SAID))
    assert verdict_of(right, true=true)["verdict"] == "accurate"
    wrong = answer(values, ("unstable", "stable", *SAID))
    assert verdict_of(wrong, true=true)["verdict"] == "WRONG"
    assert verdict_of(answer(), true=true)["missing"] == 2


def test_members_near_a_coalescence_may_lose_half_the_digits_of_their_mean():
    true = [1j, 1j, *TRUE[1:]]
    pair = answer([(1 + 3e-7) * 1j, (1 - 3e-7) * 1j, *TRUE[1:4]], ("stable", *SAID))
    assert compared(pair, np.array(true), 1e-8).error < 1e-8
    both = answer([(1 + 3e-7) * 1j, (1 + 3e-7) * 1j, *TRUE[1:4]], ("stable", *SAID))
    assert compared(both, np.array(true), 1e-8).error > 1e-7


@pytest.mark.parametrize(
    "fault", [InputError("bodies.b.material.nu", 0.5, "less"), ConvergenceError("no convergence")]
)
def test_a_refusal_is_no_answer_and_no_crash(fault):
    assert verdict_of(fault, HONEST)["verdict"] == "refused"
    assert verdict_of(fault, HONEST)["met"]
    assert not verdict_of(fault, ACCURATE)["met"]
    assert verdict_of(fault, REFUSED, None)["met"]


def test_a_refusal_must_name_what_is_wrong():
    fault = InputError("bodies.b.material.nu", 0.5, "less")
    assert verdict_of(fault, REFUSED, None, names="material.nu")["met"]
    other = verdict_of(fault, REFUSED, None, names="material.rho")
    assert (other["verdict"], other["met"]) == ("WRONG", False)


def test_a_crash_is_wrong():
    found = verdict_of(ValueError("inf is not JSON"), HONEST)
    assert (found["verdict"], found["met"]) == ("WRONG", False)
    assert "ValueError: inf is not JSON" in found["reason"]


def test_an_answer_to_what_has_none_is_wrong():
    assert verdict_of(answer(), REFUSED, None)["verdict"] == "WRONG"
    assert not verdict_of(StressAnswer(np.array([3e14]), (), 4), REFUSED, None)["met"]


def test_a_reference_that_fails_is_a_fault_and_one_that_is_refused_has_no_answer():
    def fails(error):
        def values():
            raise error

        return Reference("dense", values)

    run = Run("planted", ALONE[0], Planted(answer()), fails(ZeroDivisionError()), HONEST)
    assert "no reference" in judged(run)["reason"]
    run = replace(run, reference=fails(InputError("P", 0, "positive")))
    assert judged(run)["reason"] == "answered what has no answer"


def test_stresses_are_compared_with_the_uniform_one():
    right = StressAnswer(np.array([-1000.0, -1000.0 * (1 + 1e-9)]), (), 4)
    assert verdict_of(right, true=[-1000.0])["verdict"] == "accurate"
    wrong = StressAnswer(np.array([-1000.0, -900.0]), (), 4)
    assert verdict_of(wrong, HONEST, [-1000.0])["verdict"] == "WRONG"
