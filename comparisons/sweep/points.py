"""Points at which a scene is solved: axes, ``mu=0:1:101``, or samples, ``mu~normal:0.4:0.05``."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from scenes.spec.consistency import LARGEST, SMALLEST

_MOST = 10_000
"""Largest number of values of an axis."""
_AXIS = "name=first:last:count, or name=first:last:log:count"
_TRAINING, _IN_DECADES = 5, 17
"""Number of training points along an axis, at which bounds are evaluated to enrich the basis, and
along a wide one."""
_WIDE = 100.0
"""Ratio of the ends of an axis above which it is wide."""
_TOGETHER = 64
"""Number of samples in a group."""
_SAMPLES = 48
"""Number of training points among samples, besides those with the extreme values of fields."""
Kind = Literal["normal", "uniform", "lognormal"]
_DISTRIBUTION = (
    "name~normal:mean:deviation, name~lognormal:median:deviation of the logarithm, either followed "
    "by :low:high to truncate it, or name~uniform:low:high"
)


@dataclass(frozen=True)
class Axis:
    """Values of one field, spaced evenly or logarithmically; the name is that given by the user."""

    name: str
    first: float
    last: float
    count: int
    log: bool = False

    def __post_init__(self) -> None:
        for end in (self.first, self.last):
            _check_end(self.name, end, positive=self.log)
        other = "another last value than the first"
        require(self.first != self.last, self.name, self.last, other)
        require(2 <= self.count <= _MOST, self.name, self.count, f"2 to {_MOST} values")

    @property
    def values(self) -> list[float]:
        """The values of the axis."""
        spaced = np.geomspace if self.log else np.linspace
        return spaced(self.first, self.last, self.count).tolist()


@dataclass(frozen=True)
class Distribution:
    """Distribution of a field, truncated at ``low`` and ``high``.

    ``first`` and ``second`` are mean and standard deviation (normal), least and greatest value
    (uniform), or median and standard deviation of the logarithm (lognormal).
    """

    name: str
    kind: Kind
    first: float
    second: float
    low: float = -np.inf
    high: float = np.inf

    def __post_init__(self) -> None:
        _check_end(self.name, self.first, positive=self.kind == "lognormal")
        _check_end(self.name, self.second, positive=False)
        if self.kind == "uniform":
            greater = f"greater than {self.first:g}"
            require(self.first < self.second, self.name, self.second, greater)
        else:
            require(self.second > 0, self.name, self.second, "a positive deviation")
        require(self.low < self.high, self.name, self.high, f"greater than {self.low:g}")
        self.drawn(np.empty(0), self.low)

    def drawn(self, probability: Floats, least: float) -> tuple[Floats, float]:
        """Return quantiles of the distribution truncated at ``least``, and the fraction cut off."""
        from scipy.stats import lognorm, norm, uniform

        low, law = max(self.low, least), norm(self.first, self.second)
        if self.kind == "lognormal":
            law = lognorm(self.second, scale=self.first)
        elif self.kind == "uniform":
            law = uniform(self.first, self.second - self.first)
        before, below, above = law.cdf([self.low, low, self.high]).tolist()
        require(below < above, self.name, [low, self.high], "ends with values between them")
        values = np.clip(law.ppf(below + (above - below) * probability), low, self.high)
        return values, (below - before) / (above - before)


Field = Axis | Distribution
"""A field that varies in a sweep."""


def as_plain(field: Field) -> dict[str, Any]:
    """Return a field as plain data, without infinite ends."""
    return {name: each for name, each in asdict(field).items() if each not in (-np.inf, np.inf)}


@dataclass(frozen=True)
class Points:
    """A table of points; ``values`` has the shape (points, fields).

    ``axes`` are the values of the axes, the last varying fastest, empty for samples. ``cut`` is the
    fraction of each distribution that was cut off.
    """

    names: tuple[str, ...]
    values: Floats
    axes: tuple[Floats, ...] = ()
    cut: tuple[float, ...] = ()

    @classmethod
    def of_axes(cls, names: tuple[str, ...], axes: Sequence[Floats]) -> "Points":
        """Return all points of a grid."""
        grid = np.meshgrid(*axes, indexing="ij")
        return cls(names, np.stack([each.ravel() for each in grid], axis=1), tuple(axes))

    @property
    def counts(self) -> tuple[int, ...]:
        """Numbers of values of the axes."""
        return tuple(len(each) for each in self.axes)

    @property
    def parts(self) -> list[Ints]:
        """Indices of points that are solved and stored together: a line, or a group of samples."""
        numbers = np.arange(len(self.values))
        if self.axes:
            return list(numbers.reshape(self.counts[0], -1).T)
        return np.array_split(numbers, -(-len(numbers) // _TOGETHER))

    @property
    def training(self) -> Ints:
        """Indices of the points at which bounds are evaluated to enrich the basis."""
        numbers = np.arange(len(self.values))
        if not self.axes:
            at_ends = self.values.argmin(axis=0), self.values.argmax(axis=0)
            return np.unique(np.concatenate([*at_ends, numbers[:_SAMPLES]]))
        few = [np.linspace(0, len(each) - 1, _training_of(each)) for each in self.axes]
        chosen = np.ix_(*(each.round().astype(int) for each in few))
        return numbers.reshape(self.counts)[chosen].ravel()

    @property
    def ends(self) -> list[tuple[float, float]]:
        """Least and greatest value of each field."""
        lows, highs = self.values.min(axis=0).tolist(), self.values.max(axis=0).tolist()
        return list(zip(lows, highs, strict=True))


def _training_of(axis: Floats) -> int:
    """Return the number of training points along an axis."""
    wide = axis.min() > 0 and axis.max() > _WIDE * axis.min()
    return min(_IN_DECADES if wide else _TRAINING, len(axis))


def table_of(fields: Sequence[Field], least: Sequence[float], count: int, seed: int) -> Points:
    """Return all points of a grid of axes, or independent samples of distributions.

    ``least`` are the least allowed values of the fields; equal seeds (PCG64) draw equal samples.
    """
    names = tuple(each.name for each in fields)
    axes = [each for each in fields if isinstance(each, Axis)]
    if axes:
        return Points.of_axes(names, [np.array(each.values) for each in axes])
    spread = [each for each in fields if isinstance(each, Distribution)]
    probabilities = np.random.default_rng(seed).random((len(fields), count))
    each_of = zip(spread, probabilities, least, strict=True)
    drawn = [each.drawn(own, low) for each, own, low in each_of]
    values = np.stack([own for own, _ in drawn], axis=1)
    return Points(names, values, cut=tuple(share for _, share in drawn))


def read_axis(text: str) -> Axis:
    """Read an axis from its text; InputError when it is none."""
    name, equals, rest = text.partition("=")
    try:
        first, last, *log, count = rest.split(":")
        numbers = float(first), float(last), int(count)
    except ValueError:
        raise InputError("axis", text, _AXIS) from None
    if not (name and equals) or log not in ([], ["log"]):
        raise InputError("axis", text, _AXIS)
    return Axis(name, *numbers, bool(log))


def read_distribution(text: str) -> Distribution:
    """Read a distribution from its text; InputError when it is none."""
    name, tilde, rest = text.partition("~")
    kind, *parts = rest.split(":")
    counts = (2,) if kind == "uniform" else (2, 4)
    if not (name and tilde) or kind not in get_args(Kind) or len(parts) not in counts:
        raise InputError("distribution", text, _DISTRIBUTION)
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise InputError("distribution", text, _DISTRIBUTION) from None
    return Distribution(name, kind, *numbers)  # type: ignore[arg-type]


def read_fields(texts: Sequence[str]) -> tuple[Field, ...]:
    """Read axes or distributions from their texts; InputError when there are both."""
    spread = ["~" in text and "=" not in text.partition("~")[0] for text in texts]
    if any(spread) and not all(spread):
        other = texts[spread.index(False)]
        raise InputError("axis", other, "a distribution, as the others are: name~normal:0.4:0.05")
    read: Any = read_distribution if any(spread) else read_axis
    return tuple(map(read, texts))


def _check_end(name: str, value: float, *, positive: bool) -> None:
    """Raise InputError for a value that no field of a scene may have."""
    require(abs(value) <= LARGEST, name, value, f"a finite number of at most {LARGEST:g}")
    large = not positive or value >= SMALLEST
    require(large, name, value, f"positive, at least {SMALLEST:g}")
