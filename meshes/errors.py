"""Geometry refused before anything is built."""


class ShapeError(ValueError):
    """Geometry refused before anything is built.

    Parameters
    ----------
    field
        Name of the offending field.
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


def require(condition: bool, field: str, value: object, allowed: str) -> None:
    """Raise :class:`ShapeError` unless a condition holds."""
    if not condition:
        raise ShapeError(field, value, allowed)
