"""Modes of both backends combined: the smaller bar, overlap of the bars, stability."""

from dataclasses import dataclass, replace
from math import tau
from typing import Any

import numpy as np

from cea.eigen.classify import GROWING, Word, classify, thresholds
from cea.eigen.matching import assign
from comparisons.converge.bars import Estimated
from comparisons.converge.follow import Followed, matched
from comparisons.converge.request import Request, half_unit
from scenes.spec.body import Backend


@dataclass(frozen=True)
class Mode:
    """A mode of the report, with the value of the backend with the smaller bar."""

    backend: Backend
    estimated: Estimated  # with bars widened to the other value if the bars do not overlap
    agree: bool | None  # whether the bars overlap; None if only one backend has the mode
    rigid: bool
    word: Word

    @property
    def frequency(self) -> float:
        """Frequency (Hz)."""
        return self.estimated.value.imag / tau

    def shortfalls(self, request: Request, threshold: float | None) -> tuple[float, float]:
        """Return the bars of frequency and growth over the largest bars that the digits allow.

        Digits of growth are required of growing modes only, relative to the growth rate or the
        threshold, whichever is larger.
        """
        own = self.estimated
        if self.rigid or (request.unstable and self.word == "stable"):
            return 0.0, 0.0
        speed = max(abs(own.value), np.finfo(float).tiny)
        of_frequency = own.frequency_bar / (half_unit(request.digits) * speed)
        if self.word not in GROWING:
            return of_frequency, 0.0
        least = float(thresholds(np.array([own.value]), threshold)[0])
        scale = max(abs(own.value.real), least)
        return of_frequency, own.growth_bar / (half_unit(request.of_growth) * scale)

    def plain(self) -> dict[str, Any]:
        """Return the mode as plain data."""
        own = self.estimated
        return {
            "backend": self.backend,
            "frequency": self.frequency,
            "frequency_bar": own.frequency_bar / tau,
            "growth": own.value.real,
            "growth_bar": own.growth_bar,
            "verdict": self.word,
            "rigid": self.rigid,
            "converges": own.converges,
            "estimates": own.estimates,
            "agree": self.agree,
        }


def combine(
    followed: dict[Backend, Followed],
    bars: dict[Backend, list[Estimated]],
    threshold: float | None,
) -> list[Mode]:
    """Return the modes of the finest meshes, matched between backends; collective."""
    pairs: list[dict[Backend, int]] = []
    backends = list(followed)
    if len(backends) == 2:
        meshes = [followed[backend].meshes[-1] for backend in backends]
        for groups in matched(*meshes):
            values = [mesh.eigenvalues[own] for mesh, own in zip(meshes, groups, strict=True)]
            rows, columns = assign(np.abs(values[0][:, None] - values[1]))
            numbers = zip(groups[0][rows].tolist(), groups[1][columns].tolist(), strict=True)
            pairs += [dict(zip(backends, both, strict=True)) for both in numbers]
    for backend in backends:
        done = {numbers[backend] for numbers in pairs if backend in numbers}
        pairs += [{backend: i} for i in range(len(bars[backend])) if i not in done]
    found = [_mode(numbers, followed, bars, threshold) for numbers in pairs]
    return sorted(
        found, key=lambda mode: (float(f"{mode.frequency:.9g}"), mode.estimated.value.real)
    )


def _mode(
    numbers: dict[Backend, int],
    followed: dict[Backend, Followed],
    bars: dict[Backend, list[Estimated]],
    threshold: float | None,
) -> Mode:
    each = {backend: bars[backend][i] for backend, i in numbers.items()}
    backend = min(each, key=lambda b: each[b].frequency_bar + each[b].growth_bar)
    rigid = all(followed[b].meshes[-1].rigid[i] for b, i in numbers.items())
    words = {word_of(own, threshold, rigid=rigid) for own in each.values()}
    if len(each) == 1:
        return Mode(backend, each[backend], None, rigid, words.pop())
    (other,) = (own for b, own in each.items() if b != backend)
    best, agree = widened(each[backend], other)
    word = word_of(best, threshold, rigid=rigid)
    if "stable" in words and not words.isdisjoint(GROWING):
        word = "undecided"
    return Mode(backend, best, agree, rigid, word)


def widened(own: Estimated, other: Estimated) -> tuple[Estimated, bool]:
    """Return an eigenvalue and whether its bars overlap the other's; widen them if not."""
    frequency = abs(own.value.imag - other.value.imag)
    growth = abs(own.value.real - other.value.real)
    if (
        frequency <= own.frequency_bar + other.frequency_bar
        and growth <= own.growth_bar + other.growth_bar
    ):
        return own, True
    bars = max(own.frequency_bar, frequency), max(own.growth_bar, growth)
    still = own.still and growth == 0
    return replace(own, frequency_bar=bars[0], growth_bar=bars[1], still=still), False


def word_of(own: Estimated, threshold: float | None, *, rigid: bool = False) -> Word:
    """Classify one mode, with the bar of its growth as its error."""
    limits = thresholds(np.array([own.value]), threshold)
    error = np.inf if own.is_open else own.growth_bar
    return classify(own.value.real, error, limits, own.still, rigid)[0]
