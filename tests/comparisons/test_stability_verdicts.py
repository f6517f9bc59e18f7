"""Verdicts of stability on planted answers: right, wrong, warned, refused."""

from dataclasses import replace

import numpy as np
import pytest

from cea.errors import ConvergenceError, InputError
from comparisons.stability.case import EXPECTED, MESH, Reference, Run, formula
from comparisons.stability.problems import Answer
from comparisons.stability.verdicts import compared, judged
from comparisons.stability.ways import ALONE

TRUE = np.array([1j, 2j, 0.2 + 3j, -0.2 + 3j, 8j])
"""Eigenvalues up to and beyond a window of 4 rad/s, one pair fluttering."""
SAID = ("stable", "stable", "unstable", "stable")
WARNS = {"warnings": ("residual",)}
OPEN = {"complete": False, "verdict": "undecided"}


def answer(values=TRUE[:4], verdicts=SAID, **fields):
    """A claim of modes in a window of 4 rad/s."""
    values, verdicts = np.asarray(values, dtype=complex), tuple(verdicts)
    return replace(
        Answer(
            values,
            verdicts,
            verdict="unstable" if "unstable" in verdicts else "stable",
            thresholds=np.full(len(values), 1e-3),
            uncertainties=np.zeros(len(values)),
            complete=True,
            max_frequency=4 / (2 * np.pi),
            residual=1e-12,
            condition=1.0,
            warnings=(),
            dofs=10,
        ),
        **fields,
    )


def planted(outcome, reference, expected="accurate", **fields):
    """Verdict on a problem that answers, or fails, as it is told."""

    def solve(max_frequency):
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    return judged(Run("planted", ALONE[0], solve, reference, EXPECTED[expected], 1e-6, **fields))


def verdict_of(outcome, expected="accurate", true=TRUE, **fields):
    return planted(outcome, None if true is None else formula(list(true)), expected, **fields)


OFF = answer(TRUE[:4] * (1 + 1e-4))
WRONG = {
    "digits": OFF,
    "missing": answer(TRUE[[0, 2, 3]], SAID[1:]),
    "spurious": answer([*TRUE[:4], 3.5j], [*SAID, "stable"]),
    "twice": answer([TRUE[0], *TRUE[:4]], ["stable", *SAID]),
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_a_wrong_answer_is_wrong_without_a_word_and_warned_with_one(wrong):
    silent, said = verdict_of(wrong, "honest"), verdict_of(replace(wrong, **WARNS), "honest")
    assert (silent["verdict"], silent["met"]) == ("WRONG", False)
    assert (said["verdict"], said["met"]) == ("warned", True)
    assert not verdict_of(replace(wrong, **WARNS))["met"]
    opened = verdict_of(replace(wrong, **OPEN), "honest")
    assert opened["verdict"] == "warned"
    assert opened["says"] == "undecided, window-not-complete"


UNDECIDED = answer(verdicts=("stable", "undecided", "unstable", "stable"))
LOCKS = answer(warnings=("locking",))
NEAR = ([1j, 2j, 3.8j], 3 * ("stable",))
BEYOND = {"true": [1j, 2j, 0.2 + 4.5j, -0.2 + 4.5j, 8j]}
RIGID = {"true": [0j, 0j, *TRUE]}
ROUNDED = [1e-7 + 0j, 1e-7j, *TRUE[:4]]
DIVERGES = {"true": [5.0 + 0j, *TRUE]}
NO_NU = InputError("bodies.b.material.nu", 0.5, "less")
LARGE = np.full(4, 1e-3)
SHORT = (TRUE[:2], SAID[:2])
GROWS = 4 * ("stable",), ("unstable", *SAID[1:]), (*SAID[:3], "unstable")
"""Growing called stable, stable and decaying called growing."""
SHY = replace(OFF, warnings=("short-modes",))
NAMED = {"true": None, "names": "material.nu"}
CASES = {
    "a warning may come": (LOCKS, "accurate", {"warnings": ("locking",)}, "accurate"),
    "it excuses no error": (SHY, "honest", {}, "WRONG"),
    "unless it is none of those": (SHY, "honest", {"warnings": ()}, "warned"),
    "uncertainty admits": (replace(OFF, uncertainties=LARGE), "warned", {}, "warned"),
    "or not": (replace(OFF, uncertainties=LARGE / 100), "warned", {}, "WRONG"),
    "no loss": (replace(WRONG["missing"], uncertainties=np.ones(3)), "warned", {}, "WRONG"),
    **{str(said): (answer(verdicts=said, **WARNS), "honest", {}, "WRONG") for said in GROWS},
    "stable window lacks it": (answer(*SHORT, warnings=("short",)), "honest", {}, "WRONG"),
    "open window lacks it": (answer(*SHORT, **OPEN), "honest", {}, "warned"),
    "one beyond grows": (answer(*NEAR, **WARNS), "honest", BEYOND, "warned"),
    "and no word of it": (answer(*NEAR), "honest", BEYOND, "WRONG"),
    "divergence is in every window": (answer(), "honest", DIVERGES, "WRONG"),
    "divergence": (answer([5, *TRUE[:4]], ("unstable", *SAID)), "accurate", DIVERGES, "accurate"),
    "undecided": (UNDECIDED, "warned", {}, "warned"),
    "undecided is not accurate": (UNDECIDED, "accurate", {}, "warned"),
    "it may be": (UNDECIDED, "accurate", {"warnings": ("undecided",)}, "accurate"),
    "rigid": (answer(ROUNDED, (*2 * ("stable",), *SAID)), "accurate", RIGID, "accurate"),
    "rigid grows": (answer(ROUNDED, ("unstable", "stable", *SAID)), "accurate", RIGID, "WRONG"),
    "rigid missing": (answer(), "accurate", RIGID, "WRONG"),
    "no convergence": (ConvergenceError("none"), "honest", {}, "refused"),
    "not to be refused": (NO_NU, "accurate", {}, "refused"),
    "to be refused": (NO_NU, "refused", NAMED, "refused"),
    "for another reason": (NO_NU, "refused", NAMED | {"names": "material.rho"}, "WRONG"),
    "a crash": (ValueError("inf is not JSON"), "honest", {}, "WRONG"),
    "answered what has no answer": (answer(), "refused", {"true": None}, "WRONG"),
}


@pytest.mark.parametrize("name", CASES)
def test_verdict(name):
    outcome, expected, fields, verdict = CASES[name]
    found = verdict_of(outcome, expected, **({"warnings": MESH} | fields))
    assert (found["verdict"], found["met"]) == (verdict, verdict in EXPECTED[expected])


def test_a_warning_that_may_not_come_is_not_as_expected():
    found = verdict_of(LOCKS)
    assert (found["verdict"], found["met"], found["says"]) == ("accurate", False, "locking")


def test_members_near_a_coalescence_may_lose_half_the_digits_of_their_mean():
    true = np.array([1j, 1j, *TRUE[1:]])
    pair = answer([(1 + 3e-7) * 1j, (1 - 3e-7) * 1j, *TRUE[1:4]], ("stable", *SAID))
    assert compared(pair, true, 1e-8).error < 1e-8
    both = answer([(1 + 3e-7) * 1j, (1 + 3e-7) * 1j, *TRUE[1:4]], ("stable", *SAID))
    assert compared(both, true, 1e-8).error > 1e-7


def test_a_reference_that_fails_is_a_fault_and_one_that_is_refused_has_no_answer():
    for error, reason in ((ZeroDivisionError(), "ZeroDivision"), (NO_NU, "what has no answer")):

        def values(error=error):
            """Fail."""
            raise error

        assert reason in planted(answer(), Reference("dense", values))["reason"]
