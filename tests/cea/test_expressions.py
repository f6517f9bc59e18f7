"""Fields and coefficients as text: values, derivatives; nothing but arithmetic gets through."""

import math

import numpy as np
import pytest

from cea.errors import InputError
from cea.expressions import Expression, Formula, evaluate

X = np.random.default_rng(1).normal(size=(50, 3))
R, THETA = np.hypot(X[:, 0], X[:, 1]), np.arctan2(X[:, 1], X[:, 0])


@pytest.mark.parametrize(
    ("field", "x", "values"),
    [
        (
            "0.3 + 0.1*sin(pi*x/2)*y - where(z > 0, r, theta)**2",
            X,
            0.3
            + 0.1 * np.sin(np.pi * X[:, 0] / 2) * X[:, 1]
            - np.where(X[:, 2] > 0, R, THETA) ** 2,
        ),
        ("x + y", X[:, :2], X[:, 0] + X[:, 1]),
        ("2", X, np.full(50, 2.0)),
        (0.25, X, np.full(50, 0.25)),
    ],
    ids=range(4),
)
def test_fields_have_their_values(field, x, values):
    assert evaluate(field, x) == pytest.approx(values, rel=1e-14)


@pytest.mark.parametrize("text", ["unknown + 1", "1/0", "x/(x - x)", "(1, 2)", "x + z"])
@pytest.mark.filterwarnings("ignore:.*:RuntimeWarning")
def test_what_has_no_value_is_refused(text):
    """The plane has no z."""
    with pytest.raises(InputError, match="expression = "):
        Expression(text)(X[:, :2])


AT = {"parameters.a": 0.7, "parameters.b": -1.3}
NAMES = {"a": "parameters.a", "b": "parameters.b"}
STEP = 1e-6


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("(a/2)**2 - 1", 0.35**2 - 1),
        ("1/(2*pi*1600)", 1 / (3200 * math.pi)),
        ("sqrt(abs(b))*exp(-a)", math.sqrt(1.3) * math.exp(-0.7)),
        ("a**b", 0.7**-1.3),
    ],
)
def test_values(text, value):
    assert Formula(text, NAMES).at(AT) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "a", "a - b", "a*b", "a/b", "b/a - 1", "-a**3", "a**b", "2**a", "b**2", "+a*(b + a)",
        "sin(a*b)", "cos(a)", "tan(a)", "arctan(b)", "sinh(a)", "cosh(a*a)", "tanh(b)",
        "exp(-a*b)", "log(a)", "sqrt(a)", "abs(b)", "3", "a**0", "0*a",
    ],
)  # fmt: skip
def test_derivatives_are_those_of_differences(text):
    formula = Formula(text, NAMES)
    for name in AT:
        if name not in formula.names:
            assert formula.derivative(name, AT) == 0
            continue
        up, down = (formula.at(AT | {name: AT[name] + s * STEP}) for s in (1, -1))
        assert formula.derivative(name, AT) == pytest.approx((up - down) / (2 * STEP), abs=1e-8)


@pytest.mark.parametrize(
    "text", ["1/(a - a)", "b**0.5", "9.0**9**9**9", "exp(1000)", "log(b)", "1e308*10*a"]
)
def test_values_that_are_not_finite_are_refused(text):
    with pytest.raises(InputError, match="finite value"):
        Formula(text, NAMES).at(AT)


def test_a_derivative_that_is_not_finite_is_refused():
    formula = Formula("sqrt(a)", NAMES)
    assert formula.at({"parameters.a": 0.0}) == 0
    with pytest.raises(InputError, match="finite derivative"):
        formula.derivative("parameters.a", {"parameters.a": 0.0})
