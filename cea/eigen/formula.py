"""Coefficients of a pencil given as text: arithmetic in named parameters, with derivatives.

    C(Omega) = D1 + (Omega/Omega_ref) DG + (Omega_ref/Omega - 1) DR

has the coefficients ``1``, ``Omega/Omega_ref`` and ``Omega_ref/Omega - 1``. Nothing is run: the
text becomes a syntax tree of numbers, names, ``+ - * / **`` and a few functions, whose values and
derivatives are found by walking it.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

from cea.errors import InputError
from cea.fields import parsed

_Function = Callable[[float], float]

_FUNCTIONS: dict[str, tuple[_Function, _Function]] = {
    "sin": (math.sin, math.cos),
    "cos": (math.cos, lambda a: -math.sin(a)),
    "tan": (math.tan, lambda a: 1 + math.tan(a) ** 2),
    "arctan": (math.atan, lambda a: 1 / (1 + a * a)),
    "sinh": (math.sinh, math.cosh),
    "cosh": (math.cosh, math.sinh),
    "tanh": (math.tanh, lambda a: 1 - math.tanh(a) ** 2),
    "exp": (math.exp, math.exp),
    "log": (math.log, lambda a: 1 / a),
    "sqrt": (math.sqrt, lambda a: 0.5 / math.sqrt(a)),
    "abs": (abs, lambda a: math.copysign(1.0, a)),
}
"""Each function with its derivative."""

_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_CONSTANTS = {"pi": math.pi}

RESERVED = frozenset(_FUNCTIONS) | frozenset(_CONSTANTS)
"""Names that no parameter may have."""


@dataclass(frozen=True)
class Formula:
    """A coefficient as text, a :class:`cea.eigen.parameters.Dependence`.

    Parameters
    ----------
    text
        Arithmetic in parameters and pi: ``+ - * / **``, brackets, and sin, cos, tan, arctan, sinh,
        cosh, tanh, exp, log, sqrt, abs.
    parameters
        The parameter that each name in it stands for.
    place
        What refusals call it.

    Raises
    ------
    InputError
        When the text is something else, or names what is no parameter.
    """

    text: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    place: str = "coefficient"

    def __post_init__(self) -> None:
        try:
            used = self._used
        except ValueError as error:
            raise self._refused(f"arithmetic, for it is none: {error}") from None
        unknown = sorted(used - set(self.parameters))
        if unknown:
            raise self._refused(f"arithmetic without {', '.join(unknown)}")

    @cached_property
    def _tree(self) -> ast.expr:
        return parsed(self.text)

    @cached_property
    def _used(self) -> frozenset[str]:
        """Names in the text that are parameters.

        Raises
        ------
        ValueError
            When something in it is no arithmetic of single numbers.
        """
        functions: set[ast.expr] = set()
        for node in ast.walk(self._tree):
            if isinstance(node, ast.operator) and type(node) not in _OPERATORS:
                raise ValueError(f"{type(node).__name__} is not among + - * / **")
            if isinstance(node, ast.Compare | ast.Invert):
                raise ValueError(f"{type(node).__name__} is no arithmetic of single numbers")
            if isinstance(node, ast.Call):
                assert isinstance(node.func, ast.Name)
                if node.func.id not in _FUNCTIONS:
                    raise ValueError(f"{node.func.id} is not among {', '.join(_FUNCTIONS)}")
                functions.add(node.func)
        names = [n for n in ast.walk(self._tree) if isinstance(n, ast.Name)]
        return frozenset({n.id for n in names if n not in functions} - set(_CONSTANTS))

    def _refused(self, allowed: str) -> InputError:
        among = ", ".join(sorted(self.parameters)) or "none"
        return InputError(self.place, self.text, f"{allowed} (parameters: {among}; and pi)")

    @property
    def names(self) -> frozenset[str]:
        """Parameters it depends on."""
        return frozenset(self.parameters[name] for name in self._used)

    def at(self, values: Mapping[str, float]) -> float:
        """Value at given parameters.

        Raises
        ------
        InputError
            When it has none that is finite.
        """
        return self._finite("value", values, _value)

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Derivative in one parameter.

        Raises
        ------
        InputError
            When it has none that is finite.
        """
        inner = [short for short in self._used if self.parameters[short] == name]
        slopes = [self._finite("derivative", values, partial(_slope, each)) for each in inner]
        return sum(slopes)

    def _finite(
        self,
        what: str,
        values: Mapping[str, float],
        evaluate: Callable[[ast.expr, Mapping[str, float]], float],
    ) -> float:
        here = {short: values[self.parameters[short]] for short in self._used}
        try:
            result = evaluate(self._tree, here)
        except (ArithmeticError, ValueError):
            result = math.nan
        if isinstance(result, complex) or not math.isfinite(result):
            told = ", ".join(f"{name} = {value:g}" for name, value in sorted(here.items()))
            raise self._refused(f"of finite {what}{f', not so at {told}' if told else ''}")
        return result


def _value(node: ast.expr, values: Mapping[str, float]) -> float:
    match node:
        case ast.Constant(value=float(number)):
            return number
        case ast.Name(id=name):
            return values[name] if name in values else _CONSTANTS[name]
        case ast.UnaryOp(op=sign, operand=inner):
            return -_value(inner, values) if isinstance(sign, ast.USub) else _value(inner, values)
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATORS[type(op)](_value(left, values), _value(right, values))
        case ast.Call(func=ast.Name(id=name), args=[inner]):
            return _FUNCTIONS[name][0](_value(inner, values))
    raise ValueError(f"{type(node).__name__} is no arithmetic")


def _slope(name: str, node: ast.expr, values: Mapping[str, float]) -> float:
    """Derivative in a name, by the rules of sums, products, quotients, powers and chains."""
    match node:
        case ast.Name(id=found):
            return 1.0 if found == name else 0.0
        case ast.UnaryOp(op=sign, operand=inner):
            slope = _slope(name, inner, values)
            return -slope if isinstance(sign, ast.USub) else slope
        case ast.Call(func=ast.Name(id=function), args=[inner]):
            slope = _slope(name, inner, values)
            return slope * _FUNCTIONS[function][1](_value(inner, values)) if slope else 0.0
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _value(left, values), _value(right, values)
            da, db = _slope(name, left, values), _slope(name, right, values)
            return _of_two(op, a, b, da, db)
    return 0.0


def _of_two(op: ast.operator, a: float, b: float, da: float, db: float) -> float:
    match op:
        case ast.Add():
            return da + db
        case ast.Sub():
            return da - db
        case ast.Mult():
            return da * b + a * db
        case ast.Div():
            return da / b - a / b * (db / b)
        case _:
            base = da * b * a ** (b - 1) if da and b else 0.0
            return base + (db * math.log(a) * a**b if db else 0.0)
