"""Format of numbers: significant digits, powers of ten, counts; texts for the page."""

from collections.abc import Callable
from html import escape
from math import floor, isfinite, log10
from typing import Any

MISSING = "–"
_SLOW = 0.1  # growth rate (1/s) above which three decimals are shown
_STILL = 1e-9  # growth rate (1/s) below which 0 is shown: it is rounding
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_NARROW_SPACE = "\u202f"


def number(value: float | None, digits: int = 3, *, sign: bool = False) -> str:
    """Show a number with ``digits`` significant digits, integers in full, None as a dash."""
    if value is None or not isfinite(value):
        return MISSING
    plus = "+" if sign and value > 0 else ""
    if isinstance(value, int) or value == 0:
        return plus + _grouped(f"{value:,.0f}")
    exponent = floor(log10(abs(float(f"{value:.{digits - 1}e}"))))
    if -4 < exponent < 6:
        return plus + _grouped(f"{value:,.{max(0, digits - 1 - exponent)}f}")
    mantissa = "1" if value == 10.0**exponent else f"{value / 10.0**exponent:.{digits - 1}f}"
    return plus + _times_power_of_ten(mantissa, exponent)


def shown(digits: int, *, sign: bool = False) -> Callable[[float | None], str]:
    """Return :func:`number` with fixed options."""
    return lambda value: number(value, digits, sign=sign)


def per_cent(value: float | None, digits: int = 2) -> str:
    """Show a signed fraction in per cent."""
    return number(None if value is None else 100 * value, digits, sign=True)


def decimals(places: int, *, sign: bool = False) -> Callable[[float | None], str]:
    """Return a function that shows a number with ``places`` decimals."""

    def show(value: float | None) -> str:
        if value is None:
            return MISSING
        return ("+" if sign and value > 0 else "") + _grouped(f"{value:,.{places}f}")

    return show


def growth(value: float | None) -> str:
    """Show a growth rate (1/s) with three decimals, a slow one with three significant digits."""
    if value is None or abs(value) >= _SLOW:
        return decimals(3, sign=True)(value)
    return "0" if abs(value) < _STILL else number(value, 3, sign=True)


def counted(count: int, singular: str) -> str:
    """Count with its noun: "1 mode", "3 modes"."""
    return f"{number(count)} {singular}{'s' * (count != 1)}"


def plain(value: Any) -> str:
    """Show a parameter of a scene: short numbers, comma-separated sequences, named fields."""
    if isinstance(value, dict):
        set_ = {name: plain(v) for name, v in value.items() if v is not None}
        return ", ".join(f"{name} = {text}" for name, text in set_.items() if text)
    if isinstance(value, list | tuple):
        return ", ".join(plain(v) for v in value)
    if isinstance(value, float):
        mantissa, _, exponent = f"{value:g}".partition("e")
        return _grouped(mantissa) if not exponent else _times_power_of_ten(mantissa, int(exponent))
    return str(value)


def literal(text: Any) -> str:
    """Escape text for plotly.js, which interprets HTML tags."""
    return escape(str(text), quote=False)


def _times_power_of_ten(mantissa: str, exponent: int) -> str:
    power = f"10{str(exponent).translate(_SUPERSCRIPTS)}"
    return power if mantissa == "1" else f"{_grouped(mantissa)} · {power}"


def _grouped(text: str) -> str:
    """Put narrow spaces between thousands, and use a true minus sign."""
    return text.replace(",", _NARROW_SPACE).replace("-", "−")
