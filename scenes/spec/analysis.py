"""What a scene says of the analysis to be made."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field


@dataclass(frozen=True)
class StaticAnalysis:
    """Displacements under the loads; reports stresses over the contacts.

    Parameters
    ----------
    samples
        Points along each side of a contact at which its normal stress is reported.
    """

    kind: Literal["static"]
    samples: Annotated[int, Field(ge=2, le=1000)] = 91


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
    """

    kind: Literal["cea"]
    max_frequency: Annotated[float, Field(gt=0)]
    growth_threshold: Annotated[float, Field(ge=0)] | None = None
    min_growth: Annotated[float, Field(le=0)] | None = None

    left_out: ClassVar[tuple[str, ...]] = ("min_growth",)
    """Fields left out of plain data where they say nothing (:mod:`scenes.plain`)."""


Analysis = StaticAnalysis | ComplexEigenvalueAnalysis
