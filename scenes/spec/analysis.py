"""What a scene says of the analysis to be made."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from cea.errors import InputError

MAX_STEPS = 1000
"""Steps in which a load is put on."""

LoadSteps = Annotated[int, Field(ge=1, le=MAX_STEPS)] | tuple[float, ...]
"""A number of equal steps, or the part of the load at the end of each."""


def _check_load_steps(steps: LoadSteps | None) -> None:
    """Refuse parts of a load that do not rise from above 0 to 1."""
    if not isinstance(steps, tuple):
        return
    rising = bool(steps) and all(a < b for a, b in pairwise((0.0, *steps))) and steps[-1] == 1
    if not (rising and len(steps) <= MAX_STEPS):
        allowed = f"at most {MAX_STEPS} parts of the load that rise from above 0 to 1"
        raise InputError("load_steps", list(steps), allowed)


@dataclass(frozen=True)
class StaticAnalysis:
    """Displacements under the loads; reports stresses over the contacts.

    Parameters
    ----------
    samples
        Points along each side of a contact at which its normal stress is reported.
    load_steps
        With c_n, number of equal steps in which loads and prescribed displacements are put on; or
        the part of them at the end of each step, rising to 1.
    """

    kind: Literal["static"]
    samples: Annotated[int, Field(ge=2, le=1000)] = 91
    load_steps: LoadSteps | None = None

    def __post_init__(self) -> None:
        _check_load_steps(self.load_steps)


@dataclass(frozen=True)
class ComplexEigenvalueAnalysis:
    """All modes up to a frequency.

    Parameters
    ----------
    max_frequency
        Upper end of the window (Hz).
    growth_threshold
        Growth rate above which a mode is called unstable (1/s); by default 1e-4 of abs(lambda).
    min_growth
        With damping or rotation, growth rate (1/s), zero or less, down to which modes are sought;
        by default a tenth of the angular frequency of the upper end.
    load_steps
        Number of equal steps in which loads, and displacements that supports prescribe, are put
        on; or the part of them at the end of each step, rising to 1. The result keeps the
        equilibrium at every step. Left out, they are put on at once.
    geometric_stiffness
        Whether the stresses of steady sliding stiffen, or soften, small motions.
    """

    kind: Literal["cea"]
    max_frequency: Annotated[float, Field(gt=0)]
    growth_threshold: Annotated[float, Field(ge=0)] | None = None
    min_growth: Annotated[float, Field(le=0)] | None = None
    load_steps: LoadSteps | None = None
    geometric_stiffness: bool = False

    def __post_init__(self) -> None:
        _check_load_steps(self.load_steps)


Analysis = StaticAnalysis | ComplexEigenvalueAnalysis
