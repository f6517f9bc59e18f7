"""Fields: numbers, expressions and functions; nothing but arithmetic gets through."""

import numpy as np
import pytest

from cea.errors import InputError
from cea.expressions import Expression, evaluate

X = np.random.default_rng(1).normal(size=(50, 3))


def test_expressions_know_all_coordinates():
    values = Expression("0.3 + 0.1*sin(pi*x/2)*y - where(z > 0, r, theta)**2")(X)
    r, theta = np.hypot(X[:, 0], X[:, 1]), np.arctan2(X[:, 1], X[:, 0])
    expected = 0.3 + 0.1 * np.sin(np.pi * X[:, 0] / 2) * X[:, 1]
    expected -= np.where(X[:, 2] > 0, r, theta) ** 2
    assert values == pytest.approx(expected, rel=1e-14)


def test_numbers_and_functions_are_fields_too():
    assert evaluate(0.25, X) == pytest.approx(np.full(50, 0.25))
    assert evaluate(lambda x: x[:, 2] ** 2, X) == pytest.approx(X[:, 2] ** 2)
    assert evaluate(Expression("2"), X) == pytest.approx(np.full(50, 2.0))


def test_the_plane_has_no_z():
    assert Expression("x + y")(X[:, :2]) == pytest.approx(X[:, 0] + X[:, 1])
    with pytest.raises(InputError, match="'x \\+ z'"):
        Expression("x + z")(X[:, :2])


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').getcwd()", "open('/etc/hostname')", "fromfile('/etc/hostname')",
        "x.tofile('stolen')", "().__class__", "[i for i in x]", "lambda: 1", "x = 3", "'text'",
        "sqrt(x", "unknown + 1", "", "1/0", "x/(x - x)", "(1, 2)",
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:.*:RuntimeWarning")
def test_nothing_else_is_evaluated(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="expression = "):
        Expression(text)(X)
    assert not any(tmp_path.iterdir())
