"""Fields over an interface: numbers, expressions in the coordinates, or Python functions."""

import ast
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError

FUNCTIONS = (
    "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh",
    "exp", "log", "sqrt", "abs", "minimum", "maximum", "where", "hypot",
)  # fmt: skip
"""numpy functions an expression may call."""

MAX_LENGTH, MAX_DEPTH = 2000, 100
"""Characters an expression may have, and operations inside each other."""

_COORDINATES = ("x", "y", "z", "r", "theta")

_GRAMMAR = (
    ast.Name, ast.Load, ast.Constant, ast.Call, ast.UnaryOp, ast.BinOp, ast.Compare,
    ast.operator, ast.unaryop, ast.cmpop,
)  # fmt: skip
"""What an expression is made of: no attributes, items, comprehensions, keywords, statements."""

_NO_ARITHMETIC = (
    ast.MatMult, ast.LShift, ast.RShift, ast.Not, ast.Is, ast.IsNot, ast.In, ast.NotIn,
)  # fmt: skip


@dataclass(frozen=True)
class Expression:
    """A field given as text, read by a safe evaluator: arithmetic and a few functions, no more.

    Parameters
    ----------
    text
        Expression in x, y, z (m), or r (m) and theta (rad) about the z axis, and pi.
    """

    text: str

    def check(self, field: str, dim: int = 3) -> None:
        """Refuse what is no expression, before there are points to evaluate it at.

        Parameters
        ----------
        field
            Name of the field.
        dim
            Dimension of space: the plane has no z.

        Raises
        ------
        InputError
            Under the name of the field.
        """
        try:
            self(np.full((1, dim), 0.5))
        except InputError as error:
            singular_here = error.allowed.startswith(_FINITE) and self._varies
            if not singular_here:
                raise InputError(field, self.text, f"a number, or {error.allowed}") from None

    @property
    def constant(self) -> float | None:
        """Its value where it names no coordinate, else None."""
        return None if self._varies else float(self(np.full((1, 3), 0.5))[0])

    @property
    def _varies(self) -> bool:
        """Whether it names a coordinate."""
        return any(
            isinstance(n, ast.Name) and n.id in _COORDINATES for n in ast.walk(parsed(self.text))
        )

    def __call__(self, x: Floats) -> Floats:
        """Values at positions x (m), shape (n,).

        Raises
        ------
        InputError
            When the text is no expression of the coordinates, or not finite somewhere.
        """
        from asteval import Interpreter

        coordinates = dict(zip(_COORDINATES[:3], x.T, strict=False))
        coordinates |= {
            "r": np.hypot(x[:, 0], x[:, 1]),
            "theta": np.arctan2(x[:, 1], x[:, 0]),
        }
        names = {name: getattr(np, name) for name in FUNCTIONS} | {"pi": np.pi} | coordinates
        try:
            tree = parsed(self.text)
        except ValueError as error:
            raise self._refused(coordinates, str(error)) from None
        evaluator = Interpreter(symtable=names, minimal=True, use_numpy=False)
        with np.errstate(all="ignore"):
            value = evaluator.eval(tree, show_errors=False, raise_errors=False)
        if evaluator.error:
            raise self._refused(coordinates, str(evaluator.error[0].msg))
        if value is None:  # of operations on what they do not know, and of constants without bound
            allowed = f"an expression that is {_FINITE}; this one gives no number"
            raise InputError("expression", self.text, allowed)
        try:
            values = np.broadcast_to(np.asarray(value, dtype=float), len(x)).copy()
        except (TypeError, ValueError, OverflowError):
            raise self._refused(coordinates) from None
        if not np.isfinite(values).all():
            where = x[np.flatnonzero(~np.isfinite(values))[0]]
            raise InputError("expression", self.text, f"{_FINITE}, not so at {where}")
        return values

    def _refused(self, coordinates: dict[str, Floats], reason: str = "") -> InputError:
        allowed = f"an expression in {', '.join(coordinates)} and pi with {', '.join(FUNCTIONS)}"
        lines = reason.splitlines()
        told = f"{allowed} ({lines[0]})" if lines else allowed
        return InputError("expression", self.text, told)


@cache
def parsed(text: str) -> ast.expr:
    """Syntax tree of an expression that is nothing but arithmetic and calls of known functions.

    Whole numbers become floats: powers of them would grow without bound. The tree is shared: it is
    read and never changed.

    Raises
    ------
    ValueError
        With what is wrong.
    """
    if not isinstance(text, str):
        raise ValueError("no text")
    if len(text) > MAX_LENGTH:
        raise ValueError(f"longer than {MAX_LENGTH} characters")
    try:
        with catch_warnings():  # "0.3if" is refused below, and says so in one line
            simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(text.strip(), mode="eval").body
    except SyntaxError as error:
        raise ValueError(error.msg) from None
    except (RecursionError, MemoryError):
        raise ValueError(_TOO_DEEP) from None
    level: list[ast.AST] = [tree]
    for _ in range(MAX_DEPTH):
        for node in level:
            _check_node(node)
        level = [child for node in level for child in ast.iter_child_nodes(node)]
    if level:
        raise ValueError(_TOO_DEEP)
    return ast.fix_missing_locations(_Floats().visit(tree))


_TOO_DEEP = f"nested more than {MAX_DEPTH} deep"


def _check_node(node: ast.AST) -> None:
    """Refuse what is no arithmetic; functions take just their operands, and nowhere to write."""
    if isinstance(node, ast.BitXor):
        raise ValueError("a power is written **")
    if not isinstance(node, _GRAMMAR) or isinstance(node, _NO_ARITHMETIC):
        raise ValueError(f"{type(node).__name__} is no arithmetic")
    if isinstance(node, ast.Constant) and type(node.value) not in (int, float):
        raise ValueError(f"{type(node.value).__name__} is no number")
    if isinstance(node, ast.Compare) and len(node.ops) > 1:
        raise ValueError("one comparison at a time, joined by &")
    if isinstance(node, ast.Call):
        if not isinstance(node.func, ast.Name) or node.func.id not in FUNCTIONS:
            raise ValueError("what is called is no function")
        function: Any = getattr(np, node.func.id)
        count = getattr(function, "nin", 3)  # np.where, the one that is no ufunc, takes three
        if len(node.args) != count:
            raise ValueError(f"{node.func.id} takes {count}, not {len(node.args)}")


class _Floats(ast.NodeTransformer):
    """Whole numbers as floats."""

    def visit_Constant(self, node: ast.Constant) -> ast.Constant:
        """The number as a float."""
        assert isinstance(node.value, int | float)
        try:
            return ast.Constant(float(node.value))
        except OverflowError:
            raise ValueError("a number is too large") from None


_FINITE = "finite everywhere"

Field = float | Expression | Callable[[Floats], Floats]


def evaluate(field: Field, x: Floats) -> Floats:
    """Values of a field at positions x (m), shape (n,)."""
    if callable(field):
        return np.broadcast_to(np.asarray(field(x), dtype=float), len(x)).copy()
    return np.full(len(x), float(field))
