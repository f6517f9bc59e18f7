"""Exceptions, suggestions for misspelt names, and warnings as data."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from difflib import get_close_matches
from typing import Any
from unicodedata import category

_LONGEST = 300  # longest value or name shown in a message, in characters
_WORDS = 1200  # longest text that says what is allowed, in characters
_COMPARED = 100  # longest name for which similar names are searched, in characters


def _shown(value: object) -> str:
    """Return the repr of a value, shortened in the middle if it is long."""
    try:
        text = repr(value)
    except Exception:  # an integer with too many digits, or an object whose repr fails
        return f"a value of type {type(value).__name__}"
    return _short(text)


def _short(text: str, longest: int = _LONGEST) -> str:
    """Return text, shortened in the middle if it has more than ``longest`` characters."""
    half = longest // 2
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def printable(text: str) -> str:
    """Return text with control characters escaped, except ends of lines."""
    kept = (c.isprintable() or c == "\n" or category(c) == "Zs" for c in text)
    return "".join(c if keep else ascii(c)[1:-1] for c, keep in zip(text, kept, strict=True))


class InputError(ValueError):
    """Invalid input: the field as the user wrote it, its value, and what is allowed, as text."""

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        message = f"{_short(field)} = {_shown(value)}: {_short(allowed, _WORDS)}"
        super().__init__(printable(" ".join(message.split())))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the arguments instead of the message, so that ranks can exchange the error."""
        return type(self), (self.field, self.value, self.allowed)


class WriteError(OSError):
    """A file could not be written; no part of it is left on the disk."""


class ConvergenceError(RuntimeError):
    """An iteration did not converge; ``best`` holds the best approximation so far."""

    def __init__(self, message: str, best: Any = None) -> None:
        self.best = best
        super().__init__(message)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without the best approximation, which may be distributed over the ranks."""
        return type(self), (str(self),)


def require(condition: bool, field: str, value: object, allowed: str) -> None:
    """Raise :class:`InputError` unless a condition holds."""
    if not condition:
        raise InputError(field, value, allowed)


def did_you_mean(name: object, known: Iterable[object]) -> str:
    """Return "; did you mean 'pad'?" to end a message, or "" if no known name is similar."""
    if not isinstance(name, str) or len(name) > _COMPARED:
        return ""
    folded = {str(each).casefold(): str(each) for each in reversed(list(known))}
    found = get_close_matches(name.strip().casefold(), folded, n=1)
    return f"; did you mean {folded[found[0]]!r}?" if found and folded[found[0]] != name else ""


@dataclass(frozen=True)
class ResultWarning:
    """Warning attached to a result."""

    kind: str  # short identifier for programs, words joined by hyphens
    message: str  # the warning as a sentence
    data: Mapping[str, Any] = field(default_factory=dict)  # numbers in the message

    def plain(self) -> dict[str, Any]:
        """Return the warning as a dictionary."""
        return asdict(self)
