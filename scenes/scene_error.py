"""What is raised when a scene is refused."""

from collections.abc import Iterable
from typing import Any

from cea.errors import InputError

_SHOWN = 20
"""Faults that a message tells."""


class SceneError(ValueError):
    """A scene that is refused: one :class:`cea.errors.InputError` for each fault."""

    def __init__(self, faults: Iterable[InputError]) -> None:
        self.faults = tuple(faults)
        lines = [str(fault) for fault in self.faults[:_SHOWN]]
        if len(self.faults) > _SHOWN:
            lines.append(f"and {len(self.faults) - _SHOWN} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between ranks by its faults, not by its message."""
        return type(self), (self.faults,)
