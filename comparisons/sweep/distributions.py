"""Distributions of fields as they are given: ``mu~normal:0.4:0.05``, ``P~lognormal:1e9:0.5``."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cea.arrays import Floats
from cea.errors import InputError
from comparisons.sweep.axes import check_end

Kind = Literal["normal", "uniform", "lognormal"]
_ALLOWED = (
    "name~normal:mean:deviation, name~lognormal:median:deviation of the logarithm, with :low:high "
    "behind them to cut them off, or name~uniform:low:high"
)


@dataclass(frozen=True)
class Distribution:
    """How a field is spread.

    Parameters
    ----------
    name
        The field, as of :class:`comparisons.sweep.axes.Axis`.
    kind
        ``"normal"``, ``"uniform"`` or ``"lognormal"``.
    first, second
        Mean and standard deviation; least and greatest value; median, and standard deviation of
        the logarithm.
    low, high
        Values at which it is cut off.
    """

    name: str
    kind: Kind
    first: float
    second: float
    low: float = -np.inf
    high: float = np.inf

    def __post_init__(self) -> None:
        check_end(self.name, self.first, positive=self.kind == "lognormal")
        check_end(self.name, self.second, positive=False)
        if self.kind == "uniform":
            if not self.first < self.second:
                raise InputError(self.name, self.second, f"greater than {self.first:g}")
            return
        if self.second <= 0:
            raise InputError(self.name, self.second, "a positive deviation")
        if not self.low < self.high:
            raise InputError(self.name, self.high, f"greater than {self.low:g}")
        if not np.ptp(self._ends):
            raise InputError(self.name, [self.low, self.high], "ends with values between them")

    @property
    def _ends(self) -> Floats:
        """Probabilities below both ends."""
        from scipy.stats import norm

        return norm.cdf(self._standard(np.array([self.low, self.high])))

    def _standard(self, values: Floats) -> Floats:
        if self.kind == "normal":
            return (values - self.first) / self.second
        with np.errstate(divide="ignore"):
            return np.log(np.maximum(values, 0.0) / self.first) / self.second

    def at(self, probability: Floats) -> Floats:
        """Values below which the probability is given, shape (n,)."""
        from scipy.stats import norm

        if self.kind == "uniform":
            return self.first + (self.second - self.first) * probability
        least, most = self._ends
        standard = norm.ppf(least + (most - least) * probability)
        if self.kind == "normal":
            values = self.first + self.second * standard
        else:
            values = self.first * np.exp(self.second * standard)
        return np.clip(values, self.low, self.high)

    def plain(self) -> Mapping[str, object]:
        """It as plain data; ends that cut nothing off are left out."""
        ends = {"low": self.low, "high": self.high}
        return {
            "name": self.name,
            "kind": self.kind,
            "first": self.first,
            "second": self.second,
            **{name: value for name, value in ends.items() if np.isfinite(value)},
        }


def read_distribution(text: str) -> Distribution:
    """A distribution from its text.

    Raises
    ------
    InputError
        When it is none.
    """
    name, tilde, rest = text.partition("~")
    kind, *parts = rest.split(":")
    counts = (2,) if kind == "uniform" else (2, 4)
    if not (name and tilde) or kind not in get_args(Kind) or len(parts) not in counts:
        raise InputError("distribution", text, _ALLOWED)
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise InputError("distribution", text, _ALLOWED) from None
    return Distribution(name, kind, *numbers)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Drawn:
    """Values that were drawn of one field.

    Parameters
    ----------
    name
        The field.
    values
        The values, in the order of the samples.
    spread
        Their probabilities, in the order of the samples: evenly spread from 0 to 1, shape (n,).
    """

    name: str
    values: list[float]
    spread: Floats

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest value."""
        return min(self.values), max(self.values)

    @property
    def logarithmic(self) -> bool:
        """Whether values are evenly spaced in their logarithm."""
        return False


def draw(distributions: Sequence[Distribution], count: int, seed: int) -> tuple[Drawn, ...]:
    """Independent samples of some fields.

    Parameters
    ----------
    distributions
        Their distributions.
    count
        Number of samples.
    seed
        Of the generator (PCG64): equal seeds draw equal samples.
    """
    probabilities = np.random.default_rng(seed).random((len(distributions), count))
    return tuple(
        Drawn(each.name, each.at(own).tolist(), own)
        for each, own in zip(distributions, probabilities, strict=True)
    )
