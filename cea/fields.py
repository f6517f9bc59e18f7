"""Fields over an interface: numbers, expressions in the coordinates, or Python functions."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cea.body import Floats
from cea.errors import InputError

FUNCTIONS = (
    "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh",
    "exp", "log", "sqrt", "abs", "minimum", "maximum", "where", "hypot",
)  # fmt: skip
"""numpy functions an expression may call."""


@dataclass(frozen=True)
class Expression:
    """A field given as text, read by a safe evaluator: arithmetic and a few functions, no more.

    Parameters
    ----------
    text
        Expression in x, y, z (m), or r (m) and theta (rad) about the z axis, and pi.
    """

    text: str

    def check(self, field: str) -> None:
        """Refuse what is no expression, before there are points to evaluate it at.

        Raises
        ------
        InputError
            Under the name of the field.
        """
        try:
            self(np.full((1, 3), 0.5))
        except InputError as error:
            if not error.allowed.startswith(_FINITE):
                raise InputError(field, self.text, f"a number, or {error.allowed}") from None

    def __call__(self, x: Floats) -> Floats:
        """Values at positions x (m), shape (n,).

        Raises
        ------
        InputError
            When the text is no expression of the coordinates, or not finite somewhere.
        """
        from asteval import Interpreter

        coordinates = dict(zip("xyz", x.T, strict=False))
        coordinates |= {
            "r": np.hypot(x[:, 0], x[:, 1]),
            "theta": np.arctan2(x[:, 1], x[:, 0]),
        }
        names = {name: getattr(np, name) for name in FUNCTIONS} | {"pi": np.pi} | coordinates
        evaluator = Interpreter(symtable=names, minimal=True, use_numpy=False)
        value = evaluator(self.text, show_errors=False, raise_errors=False)
        if evaluator.error:
            reason = str(evaluator.error[0].msg).splitlines()[0]
            raise InputError("expression", self.text, f"{_allowed(coordinates)} ({reason})")
        try:
            values = np.broadcast_to(np.asarray(value, dtype=float), len(x)).copy()
        except (TypeError, ValueError):
            raise InputError("expression", self.text, _allowed(coordinates)) from None
        if not np.isfinite(values).all():
            where = x[np.flatnonzero(~np.isfinite(values))[0]]
            raise InputError("expression", self.text, f"{_FINITE}, not so at {where}")
        return values


_FINITE = "finite everywhere"

Field = float | Expression | Callable[[Floats], Floats]


def evaluate(field: Field, x: Floats) -> Floats:
    """Values of a field at positions x (m), shape (n,)."""
    if callable(field):
        return np.broadcast_to(np.asarray(field(x), dtype=float), len(x)).copy()
    return np.full(len(x), float(field))


def _allowed(coordinates: dict[str, Floats]) -> str:
    return f"an expression in {', '.join(coordinates)} and pi with {', '.join(FUNCTIONS)}"
