"""References: true answers, each with the name of where it comes from."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from cea.arrays import Complexes
from comparisons.stability.parts.dense import dense_eigenvalues
from comparisons.stability.parts.dense_damped import carried_eigenvalues, damped_eigenvalues

_BEYOND = 1.3
"""How far beyond the modes looked at an exact list reaches."""


@dataclass(frozen=True)
class Reference:
    """A true answer.

    Parameters
    ----------
    name
        Where it comes from: "dense", "at rest", "exact", "benign", "formula".
    values
        Computes it: lambda (1/s) of every mode with Im >= 0, far beyond the window; or the normal
        stress (N/m^2) of a static scene.
    """

    name: str
    values: Callable[[], Complexes]


def dense(scene: Mapping[str, Any]) -> Reference:
    """Dense eigenvalues of the assembled matrices of a scene (scipy)."""
    return Reference("dense", lambda: _values(dense_eigenvalues, _key(scene)))


def damped(scene: Mapping[str, Any]) -> Reference:
    """Dense eigenvalues of the assembled matrices of a scene with damping or rotation (scipy)."""
    return Reference("dense", lambda: _values(damped_eigenvalues, _key(scene)))


def carried(scene: Mapping[str, Any]) -> Reference:
    """Dense eigenvalues at rest of a damped body, carried along by its rotation (scipy)."""
    return Reference("at rest", lambda: _values(carried_eigenvalues, _key(scene)))


def benign(scene: Mapping[str, Any], factor: float = 1.0) -> Reference:
    """Dense eigenvalues of a scene that is the same in benign units, or of benign parameters.

    Parameters
    ----------
    scene
        The benign scene.
    factor
        By what its eigenvalues are multiplied.
    """
    return Reference("benign", lambda: factor * _values(dense_eigenvalues, _key(scene)))


def copies(number: int, scene: Mapping[str, Any]) -> Reference:
    """Dense eigenvalues of a scene, each so many times, for a scene of so many that are equal."""
    return Reference("dense", lambda: np.repeat(_values(dense_eigenvalues, _key(scene)), number))


def exact(problem: str, *, max_frequency: float, **parameters: Any) -> Reference:
    """Exact eigenvalues (:func:`exact_cea.reference.whole_spectrum`).

    Parameters
    ----------
    problem
        "drum", "blocks", "blocks_constant" or "ring".
    max_frequency
        Upper end of the window (Hz); the list reaches farther.
    parameters
        Those of the problem.
    """

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
    values = compute(json.loads(scene))
    values.flags.writeable = False
    return values
