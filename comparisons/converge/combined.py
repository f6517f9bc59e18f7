"""What both backends say of each mode together: the better value, the distance, the verdict."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.eigen.classify import GROWING, Word
from cea.eigen.eigenvalue_matching import assign
from comparisons.converge.following import Sequence, matched
from comparisons.converge.judged import Judged, frequency_of
from comparisons.converge.quantities import Member
from scenes.spec.body import Backend


@dataclass(frozen=True)
class Mode:
    """One mode as the report has it.

    Parameters
    ----------
    backend
        Whose value it is: that of the smaller bar.
    member
        The value with its bars, widened by a distance that bars do not explain.
    members
        What each backend says of it, by backend.
    agree
        Whether the backends differ by no more than their bars together; None where only one has
        the mode, or ran.
    changed
        Whether its cluster had another number of members on some mesh.
    """

    backend: Backend
    member: Member
    members: dict[Backend, Member]
    agree: bool | None
    changed: bool

    def plain(self) -> dict[str, Any]:
        """Plain data; bars that are not known are None."""
        member = self.member
        return {
            "backend": self.backend,
            "frequency": frequency_of(member),
            "frequency_bar": _known(member.frequency_bar / (2 * np.pi)),
            "growth": member.value.real,
            "growth_bar": _known(member.growth_bar),
            "verdict": member.verdict,
            "rigid": member.rigid,
            "rate": member.rate,
            "levels": member.levels,
            "agree": self.agree,
            "changed": self.changed,
            "of": {
                backend: {
                    "frequency": frequency_of(each),
                    "frequency_bar": _known(each.frequency_bar / (2 * np.pi)),
                    "growth": each.value.real,
                    "growth_bar": _known(each.growth_bar),
                    "verdict": each.verdict,
                    "rate": each.rate,
                }
                for backend, each in self.members.items()
            },
        }


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def combine(
    sequences: dict[Backend, Sequence], judged: dict[Backend, Judged], highest: float
) -> list[Mode]:
    """Modes below a frequency (rad/s) with what every backend says of them; collective."""
    backends = [backend for backend in sequences if sequences[backend].levels]
    if len(backends) == 1:
        (backend,) = backends
        found = [
            _mode({backend: member}, {backend: number}, judged)
            for number, member in enumerate(judged[backend].members)
        ]
    else:
        found = _of_both(sequences, judged, backends[0], backends[1])
    below = [mode for mode in found if mode.member.value.imag <= highest]
    return sorted(below, key=_order)


def _order(mode: Mode) -> tuple[float, float]:
    """By frequency, members of a pair by growth, whatever rounding parts them by."""
    value = mode.member.value
    return float(f"{value.imag:.9g}"), value.real


def _of_both(
    sequences: dict[Backend, Sequence],
    judged: dict[Backend, Judged],
    one: Backend,
    other: Backend,
) -> list[Mode]:
    groups = matched(sequences[one].last, sequences[other].last)
    pairs: list[tuple[int, int]] = []
    for first, second in groups:
        values = [
            np.array([judged[backend].members[i].value for i in numbers])
            for backend, numbers in ((one, first), (other, second))
        ]
        rows, columns = assign(np.abs(values[0][:, None] - values[1]))
        pairs += [(int(first[i]), int(second[j])) for i, j in zip(rows, columns, strict=True)]
    found = []
    for i, j in pairs:
        numbers: dict[Backend, int] = {one: i, other: j}
        members = {backend: judged[backend].members[n] for backend, n in numbers.items()}
        found.append(_mode(members, numbers, judged))
    for side, backend in enumerate((one, other)):
        followed = {int(n) for group in groups for n in group[side]}
        for n in set(range(len(judged[backend].members))) - followed:
            found.append(_mode({backend: judged[backend].members[n]}, {backend: n}, judged))
    return found


def _mode(
    members: dict[Backend, Member], numbers: dict[Backend, int], judged: dict[Backend, Judged]
) -> Mode:
    backend = min(members, key=lambda b: members[b].frequency_bar + members[b].growth_bar)
    best = members[backend]
    changed = any(judged[b].cluster_of(n).changed for b, n in numbers.items())
    if len(members) == 1:
        return Mode(backend, best, members, None, changed)
    a, b = members.values()
    frequency, growth = abs(a.value.imag - b.value.imag), abs(a.value.real - b.value.real)
    agree = bool(
        frequency <= a.frequency_bar + b.frequency_bar and growth <= a.growth_bar + b.growth_bar
    )
    verdicts = {a.verdict, b.verdict}
    verdict: Word = best.verdict
    if not agree:
        best = replace(
            best,
            frequency_bar=max(best.frequency_bar, frequency),
            growth_bar=max(best.growth_bar, growth),
        )
        verdict = best.verdict if len(verdicts) == 1 else "undecided"
    elif "stable" in verdicts and not verdicts.isdisjoint(GROWING):
        verdict = "undecided"
    return Mode(backend, replace(best, verdict=verdict), members, agree, changed)
