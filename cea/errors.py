"""Errors that say what was wrong, suggestions of what was meant, and warnings as data."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from difflib import get_close_matches
from typing import Any
from unicodedata import category

_LONGEST = 300  # characters of a value or a name that a message shows, at most
_WORDS = 1200  # characters of what is allowed
_COMPARED = 100  # characters of names for which a similar one is searched


def _shown(value: object) -> str:
    """A value as Python writes it, its middle left out where it is long."""
    try:
        text = repr(value)
    except Exception:  # a whole number of too many digits, or what cannot show itself
        return f"a value of type {type(value).__name__}"
    return _short(text)


def _short(text: str, longest: int = _LONGEST) -> str:
    """Text, its middle left out where it is long."""
    half = longest // 2
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def printable(text: str) -> str:
    """Text whose signs that a terminal would obey are written out, but for ends of lines."""
    kept = (c.isprintable() or c == "\n" or category(c) == "Zs" for c in text)
    return "".join(c if keep else ascii(c)[1:-1] for c, keep in zip(text, kept, strict=True))


class InputError(ValueError):
    """Input refused: the field as the user wrote it, its value, and what is allowed, in words."""

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        message = f"{_short(field)} = {_shown(value)}: {_short(allowed, _WORDS)}"
        super().__init__(printable(" ".join(message.split())))

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between ranks by what it was made from, not by its message."""
        return type(self), (self.field, self.value, self.allowed)


class WriteError(OSError):
    """A file that could not be written, of which nothing is left behind."""


class ConvergenceError(RuntimeError):
    """An iteration that stopped short: what did not converge, and the best answer so far."""

    def __init__(self, message: str, best: Any = None) -> None:
        self.best = best
        super().__init__(message)

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between ranks without the best answer, which may be spread over them."""
        return type(self), (str(self),)


def require(condition: bool, field: str, value: object, allowed: str) -> None:
    """Raise :class:`InputError` unless a condition holds."""
    if not condition:
        raise InputError(field, value, allowed)


def did_you_mean(name: object, known: Iterable[object]) -> str:
    """The end of a message: "; did you mean 'pad'?", or nothing where no known name is near."""
    if not isinstance(name, str) or len(name) > _COMPARED:
        return ""
    folded = {str(each).casefold(): str(each) for each in reversed(list(known))}
    found = get_close_matches(name.strip().casefold(), folded, n=1)
    return f"; did you mean {folded[found[0]]!r}?" if found and folded[found[0]] != name else ""


@dataclass(frozen=True)
class ResultWarning:
    """Something a reader of a result must know."""

    kind: str  # what it is about, one word or a few joined by hyphens: programs look at this
    message: str  # the same in a sentence
    data: Mapping[str, Any] = field(default_factory=dict)  # its numbers

    def plain(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)
