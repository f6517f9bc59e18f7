"""Where an application shows how far it is."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """Where progress is shown: one call as a step begins, one for each stage in it."""

    step: Callable[[str], None]
    stage: Callable[[str], None]
