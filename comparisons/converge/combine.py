"""What both backends say of each mode together: the better value, overlap of the bars, the word."""

from dataclasses import dataclass, replace
from math import isfinite, tau
from typing import Any

import numpy as np

from cea.eigen.classify import GROWING, Word, classify, thresholds
from cea.eigen.eigenvalue_matching import assign
from comparisons.converge.bars import Estimated
from comparisons.converge.follow import Followed, matched
from comparisons.converge.request import Request, half_unit
from scenes.spec.body import Backend


@dataclass(frozen=True)
class Mode:
    """One mode as the report has it.

    Parameters
    ----------
    backend
        Whose value it is: that of the smaller bar.
    estimated
        The value with its bars, widened to the value of the other backend where bars do not meet.
    agree
        Whether the bars of both backends meet; None where only one has the mode, or ran.
    rigid
        Whether it is a motion that nothing holds.
    word
        Its word, with the bar of its growth as error (:func:`cea.eigen.classify.classify`).
    """

    backend: Backend
    estimated: Estimated
    agree: bool | None
    rigid: bool
    word: Word

    @property
    def frequency(self) -> float:
        """Frequency (Hz)."""
        return self.estimated.value.imag / tau

    def shortfalls(self, request: Request, threshold: float | None) -> tuple[float, float]:
        """Bars of frequency and of growth over those that the digits allow, 1 or less if held.

        Digits of growth are asked of modes that grow, relative to no less than the threshold.
        """
        own = self.estimated
        if self.rigid or (request.unstable and self.word == "stable"):
            return 0.0, 0.0
        if not own.converges:
            return np.inf, np.inf if self.word in GROWING else 0.0
        speed = max(abs(own.value), np.finfo(float).tiny)
        of_frequency = own.frequency_bar / (half_unit(request.digits) * speed)
        if self.word not in GROWING:
            return of_frequency, 0.0
        least = float(thresholds(np.array([own.value]), threshold)[0])
        scale = max(abs(own.value.real), least)
        return of_frequency, own.growth_bar / (half_unit(request.of_growth) * scale)

    def plain(self) -> dict[str, Any]:
        """Plain data; bars that are not known are None."""
        own = self.estimated
        return {
            "backend": self.backend,
            "frequency": self.frequency,
            "frequency_bar": _known(own.frequency_bar / tau),
            "growth": own.value.real,
            "growth_bar": _known(own.growth_bar),
            "verdict": self.word,
            "rigid": self.rigid,
            "converges": own.converges,
            "estimates": own.estimates,
            "agree": self.agree,
        }


def _known(value: float) -> float | None:
    return float(value) if isfinite(value) else None


def combine(
    followed: dict[Backend, Followed],
    bars: dict[Backend, list[Estimated]],
    threshold: float | None,
) -> list[Mode]:
    """Modes of the finest meshes with what every backend says of them; collective.

    Parameters
    ----------
    followed, bars
        Meshes, and modes of the finest ones with their bars, by backend.
    threshold
        Growth rate (1/s) above which a mode is called unstable; None takes 1e-4 of abs(lambda).
    """
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
    best, agree = each[backend], None
    rigid = all(followed[b].meshes[-1].rigid[i] for b, i in numbers.items())
    word = word_of(best, threshold, rigid=rigid)
    if len(each) == 2:
        a, b = each.values()
        frequency, growth = abs(a.value.imag - b.value.imag), abs(a.value.real - b.value.real)
        agree = bool(
            frequency <= a.frequency_bar + b.frequency_bar and growth <= a.growth_bar + b.growth_bar
        )
        if not agree:
            best = replace(
                best,
                frequency_bar=max(best.frequency_bar, frequency),
                growth_bar=max(best.growth_bar, growth),
                still=best.still and not growth,
            )
            word = word_of(best, threshold, rigid=rigid)
        other = {word_of(own, threshold, rigid=rigid) for own in each.values()} - {word}
        if (word == "stable" and other & set(GROWING)) or (word in GROWING and "stable" in other):
            word = "undecided"
    return Mode(backend, best, agree, rigid, word)


def word_of(own: Estimated, threshold: float | None, *, rigid: bool = False) -> Word:
    """The word of one mode, with the bar of its growth as error; an open one is undecided."""
    limits = thresholds(np.array([own.value]), threshold)
    error = np.inf if own.is_open else own.growth_bar
    bounded = own.still and isfinite(own.frequency_bar)
    return classify(own.value.real, error, limits, bounded, rigid)[0]
