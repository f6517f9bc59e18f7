"""Warnings as data: what a result must be read with, told apart by kind."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class ResultWarning:
    """Something a reader of a result must know.

    Parameters
    ----------
    kind
        What it is about, one word or a few joined by hyphens: programs look at this.
    message
        The same in a sentence.
    data
        Its numbers.
    """

    kind: str
    message: str
    data: Mapping[str, Any] = field(default_factory=dict)

    def plain(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)
