"""Errors that say what was wrong and, where there is one, the best answer so far."""

from typing import Any


class InputError(ValueError):
    """Input refused before work begins.

    Parameters
    ----------
    field
        Name of the offending field as the user wrote it, e.g. ``bodies.pad.material.rho``.
    value
        The value that was given.
    allowed
        What is allowed, in words.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        super().__init__(f"{field} = {value!r}: {allowed}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between ranks by what it was made from, not by its message."""
        return type(self), (self.field, self.value, self.allowed)


class ConvergenceError(RuntimeError):
    """An iteration that stopped short.

    Parameters
    ----------
    message
        What did not converge, and by how much.
    best
        The best answer so far.
    """

    def __init__(self, message: str, best: Any = None) -> None:
        self.best = best
        super().__init__(message)


def require(condition: bool, field: str, value: object, allowed: str) -> None:
    """Raise :class:`InputError` unless a condition holds."""
    if not condition:
        raise InputError(field, value, allowed)
