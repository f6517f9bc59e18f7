"""Matching modes of two discretisations of one scene by shape on common points."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from cea.modes import Complexes
from cea.system import CoupledSystem
from comparisons.run import SceneResult
from comparisons.scene import ComplexEigenvalueAnalysis

_SAMPLES = 15
_FREQUENCY_SCALE = 0.02
"""Relative difference of frequency that counts as much as a modal assurance of zero."""


def modal_assurance(left: Complexes, right: Complexes) -> NDArray[np.float64]:
    """Modal assurance criterion of every pair of complex modes.

    Parameters
    ----------
    left, right
        Displacements at common points, shapes (n, modes_left) and (n, modes_right).

    Returns
    -------
    ndarray
        abs(x^H y)^2 / (x^H x y^H y) between 0 and 1, shape (modes_left, modes_right).
    """
    left = left / np.linalg.norm(left, axis=0)
    right = right / np.linalg.norm(right, axis=0)
    return np.abs(left.conj().T @ right) ** 2


def match_unstable(first: SceneResult, second: SceneResult) -> dict[str, Any]:
    """Pair the unstable modes of two runs of one scene.

    Modes are paired so that shape and frequency agree best over all pairs together; nothing is
    left out of the answer.

    Returns
    -------
    dict
        ``pairs``: each with frequency and growth of both, relative differences and modal
        assurance; ``only_first``, ``only_second``: modes without a partner.
    """
    chosen = [_unstable(result) for result in (first, second)]
    shapes = _common_shapes(first, second, *chosen)
    mac = modal_assurance(*shapes)
    frequencies = [
        r.modes.frequencies[c] for r, c in zip((first, second), chosen, strict=True) if r.modes
    ]
    growths = [
        r.modes.growth_rates[c] for r, c in zip((first, second), chosen, strict=True) if r.modes
    ]
    distance = np.abs(frequencies[0][:, None] / frequencies[1] - 1)
    rows, columns = linear_sum_assignment(1 - mac + distance / _FREQUENCY_SCALE)
    pairs = [
        {
            "frequency": [float(frequencies[0][i]), float(frequencies[1][j])],
            "growth": [float(growths[0][i]), float(growths[1][j])],
            "frequency_difference": float(frequencies[0][i] / frequencies[1][j] - 1),
            "growth_difference": float(growths[0][i] / growths[1][j] - 1),
            "modal_assurance": float(mac[i, j]),
        }
        for i, j in zip(rows, columns, strict=True)
    ]
    return {
        "pairs": pairs,
        "only_first": _alone(frequencies[0], growths[0], rows),
        "only_second": _alone(frequencies[1], growths[1], columns),
    }


def _unstable(result: SceneResult) -> NDArray[np.int64]:
    assert result.modes is not None
    assert isinstance(result.scene.analysis, ComplexEigenvalueAnalysis)
    return np.flatnonzero(result.modes.unstable(result.scene.analysis.growth_threshold))


def _alone(
    frequencies: NDArray[np.float64], growths: NDArray[np.float64], paired: NDArray[np.int64]
) -> list[dict[str, float]]:
    rest = np.setdiff1d(np.arange(len(frequencies)), paired)
    return [{"frequency": float(frequencies[i]), "growth": float(growths[i])} for i in rest]


def _common_shapes(
    first: SceneResult,
    second: SceneResult,
    first_modes: NDArray[np.int64],
    second_modes: NDArray[np.int64],
) -> tuple[Complexes, Complexes]:
    """Displacements of both runs at points of the contact surfaces that both can locate."""
    left, right = [], []
    for spec in first.scene.contacts.values():
        for place in (spec.a, spec.b):
            body, name = place.split(".")
            surface = first.system.bodies[body].surfaces[name]
            other = second.system.bodies[body].surfaces[name]
            points = surface.grid(max(2, round(_SAMPLES / np.sqrt(surface.num_elements))))
            found = other.locate(points.x, points.normal, other.mesh_size)
            hit = ~found.missed
            left.append(_shapes(first, body, surface.trace(points.at[hit]), first_modes))
            right.append(_shapes(second, body, other.trace(found.at[hit]), second_modes))
    return np.concatenate(left), np.concatenate(right)


def _shapes(result: SceneResult, body: str, trace: Any, modes: NDArray[np.int64]) -> Complexes:
    assert result.modes is not None
    columns = []
    for mode in modes:
        u = complex_displacement(result.system, body, *result.modes.vector(int(mode)))
        columns.append((trace @ u).ravel())
    rows = trace.shape[0] * result.system.bodies[body].dim
    return np.stack(columns, axis=1) if columns else np.empty((rows, 0), complex)


def complex_displacement(
    system: CoupledSystem, body: str, real: Any, imaginary: Any, *, everywhere: bool = True
) -> Complexes:
    """Complex displacement (m) of the scalar dofs of a body, shape (num_scalar_dofs, dim).

    On every rank, or on rank 0 only and empty on others.
    """
    u = system.displacement(real, body, everywhere=everywhere).astype(complex)
    u += 1j * system.displacement(imaginary, body, everywhere=everywhere)
    return u.reshape(-1, system.bodies[body].dim)
