"""Expressions given as text: fields over an interface, and coefficients of a matrix pencil.

The text is never executed: it is parsed to a syntax tree of numbers, names, operators and a few
numpy functions, and the tree is evaluated and differentiated recursively. For example,

    C(Omega) = D1 + (Omega/Omega_ref) DG + (Omega_ref/Omega - 1) DR

has the coefficients ``1``, ``Omega/Omega_ref`` and ``Omega_ref/Omega - 1``.
"""

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from sys import float_info
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError

_DERIVATIVES: dict[str, Callable[[Any], Any]] = {
    "sin": np.cos,
    "cos": lambda a: -np.sin(a),
    "tan": lambda a: 1 + np.tan(a) ** 2,
    "arctan": lambda a: 1 / (1 + a * a),
    "sinh": np.cosh,
    "cosh": np.sinh,
    "tanh": lambda a: 1 - np.tanh(a) ** 2,
    "exp": np.exp,
    "log": lambda a: 1 / a,
    "sqrt": lambda a: 0.5 / np.sqrt(a),
    "abs": lambda a: np.copysign(1.0, a),
}
"""Derivatives of the functions allowed in coefficients."""
FUNCTIONS = (*_DERIVATIVES, "arcsin", "arccos", "arctan2", "minimum", "maximum", "where", "hypot")
"""Numpy functions allowed in fields."""
_SMOOTH: dict[type[ast.AST], Any] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
    ast.USub: np.negative,
    ast.UAdd: np.positive,
}
"""Operators allowed in coefficients."""
_OPERATORS: dict[type[ast.AST], Any] = {
    **_SMOOTH,
    ast.Mod: np.mod,
    ast.FloorDiv: np.floor_divide,
    ast.BitAnd: np.bitwise_and,
    ast.BitOr: np.bitwise_or,
    ast.Invert: np.invert,
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}
_CONSTANTS = {"pi": np.pi}

RESERVED = frozenset(_DERIVATIVES) | frozenset(_CONSTANTS)
"""Names that parameters must not have."""

MAX_LENGTH, MAX_DEPTH = 2000, 100
"""Largest number of characters of an expression, and largest depth of nested operations."""

_COORDINATES = ("x", "y", "z", "r", "theta")
_GRAMMAR = (ast.Name, ast.Load, ast.Constant, ast.Call, ast.UnaryOp, ast.BinOp, *_SMOOTH)
"""Syntax allowed in coefficients: no attributes, items, comprehensions, keywords, statements."""
_TOO_DEEP = f"nested more than {MAX_DEPTH} deep"
_FINITE = "finite everywhere"


@dataclass(frozen=True)
class Expression:
    """Field given as text: arithmetic and the functions of :data:`FUNCTIONS`, evaluated safely."""

    text: str  # in x, y, z (m), or r (m) and theta (rad) about the z axis, and pi

    def check(self, field: str, dim: int = 3) -> None:
        """Raise :class:`InputError` if the text is not a valid expression in ``dim`` dimensions."""
        try:
            self(np.full((1, dim), 0.5))
        except InputError as error:
            singular_here = error.allowed.startswith(_FINITE) and self._varies
            if not singular_here:
                raise InputError(field, self.text, f"a number, or {error.allowed}") from None

    @property
    def constant(self) -> float | None:
        """Value if the expression contains no coordinate, else None."""
        return None if self._varies else float(self(np.full((1, 3), 0.5))[0])

    @property
    def _varies(self) -> bool:
        """Whether the expression contains a coordinate."""
        return not _variables(parsed(self.text)).isdisjoint(_COORDINATES)

    def __call__(self, x: Floats) -> Floats:
        """Values at positions x (m), shape (n,)."""
        names = dict(zip(_COORDINATES[:3], x.T, strict=False))
        names |= {"r": np.hypot(x[:, 0], x[:, 1]), "theta": np.arctan2(x[:, 1], x[:, 0])}
        allowed = f"an expression in {', '.join(names)} and pi with {', '.join(FUNCTIONS)}"
        try:
            with np.errstate(all="ignore"):
                value = _value(parsed(self.text), names)
            values = np.broadcast_to(np.asarray(value, dtype=float), len(x)).copy()
        except TypeError:  # for instance bitwise operators applied to floats
            allowed = f"an expression that is {_FINITE}; this one has no numerical value"
            raise InputError("expression", self.text, allowed) from None
        except ValueError as error:
            reason = "".join(f" ({line})" for line in str(error).splitlines()[:1])
            raise InputError("expression", self.text, allowed + reason) from None
        if not np.isfinite(values).all():
            where = x[np.flatnonzero(~np.isfinite(values))[0]]
            raise InputError("expression", self.text, f"{_FINITE}; it is not finite at {where}")
        return values


def evaluate(field: float | str, x: Floats) -> Floats:
    """Return the values of a number or an expression at positions x (m), shape (n,)."""
    return Expression(field)(x) if isinstance(field, str) else np.full(len(x), float(field))


@dataclass(frozen=True)
class Formula:
    """Coefficient given as text, a :class:`cea.eigen.coefficients.Dependence`.

    The text is arithmetic in pi and the keys of ``parameters``: ``+ - * / **``, brackets, and sin,
    cos, tan, arctan, sinh, cosh, tanh, exp, log, sqrt, abs. Anything else raises
    :class:`InputError`, which names ``place``.
    """

    text: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    place: str = "coefficient"

    def __post_init__(self) -> None:
        try:
            used = self._used
        except ValueError as error:
            raise self._refused(f"an arithmetic expression: {error}") from None
        unknown = sorted(used - set(self.parameters))
        if unknown:
            raise self._refused(f"an expression of known parameters, not {', '.join(unknown)}")

    @property
    def _tree(self) -> ast.expr:
        return parsed(self.text, smooth=True)

    @cached_property
    def _used(self) -> frozenset[str]:
        """Names of parameters in the text."""
        return _variables(self._tree)

    def _refused(self, allowed: str) -> InputError:
        among = ", ".join(sorted(self.parameters)) or "none"
        return InputError(self.place, self.text, f"{allowed} (parameters: {among}; and pi)")

    @property
    def names(self) -> frozenset[str]:
        """Parameters that the coefficient depends on."""
        return frozenset(self.parameters[name] for name in self._used)

    def at(self, values: Mapping[str, float]) -> float:
        """Return the value at given parameters."""
        return self._finite("value", values)

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Return the derivative with respect to one parameter."""
        inner = [short for short in self._used if self.parameters[short] == name]
        return sum(self._finite("derivative", values, short) for short in inner)

    def _finite(self, what: str, values: Mapping[str, float], name: str = "") -> float:
        here = {short: np.float64(values[self.parameters[short]]) for short in self._used}
        with np.errstate(all="ignore"):
            result = float(_slope(self._tree, here, name) if name else _value(self._tree, here))
        if not np.isfinite(result):
            told = ", ".join(f"{short} = {value:g}" for short, value in sorted(here.items()))
            where = f"; it is not finite at {told}" if told else ""
            raise self._refused(f"an expression of finite {what}{where}")
        return result


def _variables(tree: ast.expr) -> frozenset[str]:
    """Return the names in a tree, except constants and names of called functions."""
    nodes = list(ast.walk(tree))
    called = [node.func for node in nodes if isinstance(node, ast.Call)]
    names = {n.id for n in nodes if isinstance(n, ast.Name) and n not in called}
    return frozenset(names - set(_CONSTANTS))


@cache
def parsed(text: str, *, smooth: bool = False) -> ast.expr:
    """Parse a field, or a coefficient (``smooth``), to a syntax tree; ValueError if invalid."""
    if not isinstance(text, str):
        raise ValueError("not a string")
    if len(text) > MAX_LENGTH:
        raise ValueError(f"longer than {MAX_LENGTH} characters")
    try:
        with catch_warnings():  # "0.3if" is refused below with a message of one line
            simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(text.strip(), mode="eval").body
    except SyntaxError as error:
        raise ValueError(error.msg) from None
    except (RecursionError, MemoryError):
        raise ValueError(_TOO_DEEP) from None
    _check(tree, MAX_DEPTH, smooth)
    return tree


def _check(node: ast.AST, depth: int, smooth: bool) -> None:
    """Raise ValueError if a node, or any node below it, is not allowed or is nested too deep.

    Functions must have exactly their operands, so that no output array can be passed.
    """
    if not depth:
        raise ValueError(_TOO_DEEP)
    if isinstance(node, ast.BitXor):
        raise ValueError("a power is written **")
    if not isinstance(node, _GRAMMAR if smooth else (*_GRAMMAR, ast.Compare, *_OPERATORS)):
        raise ValueError(f"{type(node).__name__} is not allowed")
    match node:
        case ast.Constant(value=value):
            if not isinstance(value, int | float) or isinstance(value, bool):
                raise ValueError(f"{type(value).__name__} is not a number")
            if abs(value) > float_info.max:
                raise ValueError("a number is too large")
        case ast.Compare(ops=[_, _, *_]):
            raise ValueError("one comparison at a time, joined by &")
        case ast.Call(func=ast.Name(id=name), args=args):
            known = _DERIVATIVES if smooth else FUNCTIONS
            if name not in known:
                raise ValueError(f"{name} is not among {', '.join(known)}")
            # np.where is not a ufunc and has no nin; it takes three arguments.
            if len(args) != (count := getattr(getattr(np, name), "nin", 3)):
                raise ValueError(f"{name} takes {count} arguments, not {len(args)}")
        case ast.Call():
            raise ValueError("only functions can be called")
    for child in ast.iter_child_nodes(node):
        _check(child, depth - 1, smooth)


def _value(node: ast.AST, names: Mapping[str, Any]) -> Any:
    """Evaluate a tree at numbers, or arrays, given by name."""
    match node:
        case ast.Constant(value=int() | float() as number):
            return np.float64(number)
        case ast.Name(id=name):
            if name not in names and name not in _CONSTANTS:
                raise ValueError(f"{name} is unknown")
            return names[name] if name in names else _CONSTANTS[name]
        case ast.UnaryOp(op=op, operand=inner):
            return _OPERATORS[type(op)](_value(inner, names))
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATORS[type(op)](_value(left, names), _value(right, names))
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            return _OPERATORS[type(op)](_value(left, names), _value(right, names))
        case ast.Call(func=ast.Name(id=name), args=args):
            return getattr(np, name)(*(_value(each, names) for each in args))
    raise ValueError(f"{type(node).__name__} is not allowed")


def _slope(node: ast.AST, names: Mapping[str, Any], name: str) -> Any:
    """Return the derivative of a coefficient's tree with respect to a name."""
    match node:
        case ast.UnaryOp(op=op, operand=inner):
            return _OPERATORS[type(op)](_slope(inner, names, name))
        case ast.Call(func=ast.Name(id=function), args=[inner]):
            da = _slope(inner, names, name)
            return da * _DERIVATIVES[function](_value(inner, names)) if da else 0.0
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _value(left, names), _value(right, names)
            da, db = _slope(left, names, name), _slope(right, names, name)
            match op:
                case ast.Add() | ast.Sub():
                    return _OPERATORS[type(op)](da, db)
                case ast.Mult():
                    return da * b + a * db
                case ast.Div():
                    return da / b - a / b * (db / b)
            base = da * b * a ** (b - 1) if da and b else 0.0
            return base + (db * np.log(a) * a**b if db else 0.0)
    return float(isinstance(node, ast.Name) and node.id == name)
