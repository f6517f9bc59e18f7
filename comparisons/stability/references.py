"""References: true answers, each with the name of where it comes from."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from cea.arrays import Complexes
from comparisons.stability.dense import carried_eigenvalues, dense_eigenvalues

_BEYOND = 1.3
"""How far beyond the modes looked at an exact list reaches."""


@dataclass(frozen=True)
class Reference:
    """A true answer."""

    name: str  # where it comes from: "dense", "at rest", "exact", "formula"
    values: Callable[[], Complexes]  # lambda (1/s) with Im >= 0, far beyond the window


def dense(scene: Mapping[str, Any], *, factor: float = 1.0, copies: int = 1) -> Reference:
    """Dense eigenvalues of the assembled matrices of a scene (scipy), times a factor.

    Each so many times, for a scene of so many ``copies`` of this one.
    """

    def values() -> Complexes:
        return np.repeat(factor * _values(dense_eigenvalues, _key(scene)), copies)

    return Reference("dense", values)


def carried(scene: Mapping[str, Any]) -> Reference:
    """Dense eigenvalues at rest of a damped body, carried along by its rotation (scipy)."""
    return Reference("at rest", lambda: _values(carried_eigenvalues, _key(scene)))


def exact(problem: str, *, max_frequency: float, **parameters: Any) -> Reference:
    """Exact eigenvalues of a problem with its parameters, beyond a window's end (Hz)."""

    def values() -> Complexes:
        from exact_cea.reference import whole_spectrum

        top = _BEYOND * 2 * np.pi * max_frequency
        return whole_spectrum(problem, max_frequency=top, **parameters).values

    return Reference("exact", values)


def formula(values: Sequence[complex]) -> Reference:
    """Values by a closed formula."""
    return Reference("formula", lambda: np.asarray(values, dtype=complex))


def _key(scene: Mapping[str, Any]) -> str:
    """A scene as text, the saddle form for the penalty: both have the same eigenvalues."""
    data = json.loads(json.dumps(scene))
    for contact in data.get("contacts", {}).values():
        contact.pop("form", None)
    return json.dumps(data, sort_keys=True)


@cache
def _values(compute: Callable[[dict[str, Any]], Complexes], scene: str) -> Complexes:
    return compute(json.loads(scene))
