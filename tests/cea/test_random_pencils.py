"""Random pencils agree with dense eigenvalues, every copy counted, verdicts and errors too."""

from functools import partial

import pytest
from random_pencils import (
    random_graded,
    random_graded_damped,
    random_linear,
    random_low_rank,
    random_quadratic,
)
from random_runs import judged, pencil_outcome

from cea.eigen import driver
from cea.eigen.krylov_schur import KrylovOptions

PENCILS = {
    "linear": random_linear,
    "quadratic": random_quadratic,
    "low_rank": random_low_rank,
    "graded": random_graded,
    "graded_damped": random_graded_damped,
}


def check(kind, seeds, refused=0.0):
    """Nothing is wrong, little but of graded pencils is refused or left open."""
    outcomes = judged(seeds, lambda seed: pencil_outcome(PENCILS[kind](seed)))
    assert sum(outcome.modes for outcome in outcomes) > len(seeds)
    graded = kind.startswith("graded")
    assert graded or sum(bool(o.refused) for o in outcomes) <= refused * len(outcomes)
    known = [o for o in outcomes if o.refused is None and o.complete and not o.undecided]
    assert not graded or len(known) > 0.95 * len(outcomes)


slow = partial(pytest.param, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("kind", "seeds"),
    [
        ("linear", range(12)),
        ("linear", (556,)),  # where the faster driver of singular values fails
        ("quadratic", range(12)),
        ("quadratic", (226, 496, 939)),  # lambda of free motions is zero to the last digit
        ("low_rank", range(8)),
        ("graded", range(20)),
        ("graded_damped", range(6)),
        slow("linear", range(1000)),
        slow("quadratic", range(1000)),
        slow("low_rank", range(500)),
        slow("graded", range(1000)),
        slow("graded_damped", range(300)),
    ],
)
def test_lapack_tells_all_of_small_ones(kind, seeds):
    check(kind, seeds)


@pytest.mark.parametrize(
    ("kind", "seeds"),
    [
        ("linear", (19, 27, 32, 47, 59, 109, 410, 516)),  # more copies than a block has columns
        ("quadratic", range(6)),
        slow("linear", range(300)),
        slow("quadratic", range(300)),
        slow("low_rank", range(150)),
    ],
)
def test_krylov_spaces_find_all_of_them_too(kind, seeds, monkeypatch):
    """Searched as large systems are."""
    monkeypatch.setattr(driver, "KrylovOptions", lambda: KrylovOptions(dense_limit=0))
    check(kind, seeds, refused=0.01)
