"""Norms of residuals where a stiffness is larger than in the energy norm of the map.

X is the stiffness at the least parameters. At others it is X + sum_j b_j A_j and more, A_j the
symmetric pieces that vary by decades and b_j by how much their coefficients are larger: forces of a
stiff contact bend it far less than X allows. In the dual norm of that sum

    |r|^2 = min over u_j of  |r - sum_j b_j A_j u_j|^2 + sum_j b_j u_j^T A_j u_j,

norms on the right in X^-1, so that every choice of u_j bounds it from above: they are sought in the
span of the basis, whose images are known by their coordinates. With those images and the roots of
A_j one above the other, Z = Q R, and Q parted into Q_1 and Q_2 alike, the least is the length of

    (1 - Q_1 (1 + (Q_2^T Q_2)^(1/2))^-1 Q_1^T) r,

and no squares are subtracted.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.reduced.products import real_times

_STIFFER = 2.0
"""Ratio of a coefficient to that in X from which on a norm of its own tells more."""


@dataclass(frozen=True)
class StiffNorm:
    """What takes coordinates of residuals to such whose lengths are their norms.

    Parameters
    ----------
    forces
        Q_1, shape (q, k).
    weights
        (1 + (Q_2^T Q_2)^(1/2))^-1, shape (k, k).
    """

    forces: Floats
    weights: Floats

    def real(self, residuals: Floats) -> Floats:
        """Of real residuals, shape (q, n)."""
        measured: Floats = residuals - self.forces @ (self.weights @ (self.forces.T @ residuals))
        return measured

    def __call__(self, residuals: NDArray[np.inexact]) -> Complexes:
        """Of residuals, shape (q, n)."""
        along = real_times(self.weights, real_times(self.forces.T, residuals))
        return residuals - real_times(self.forces, along)


def stiff_norm(parts: Sequence[tuple[float, float, Floats, Floats]]) -> StiffNorm | None:
    """The norm where some pieces are stiffer.

    Parameters
    ----------
    parts
        Of each piece A_j: its coefficient and that in X, the coordinates Q^T A_j V of its images,
        shape (q, k), and V^T A_j V, shape (k, k).

    Returns
    -------
    StiffNorm or None
        None where no piece is much stiffer.
    """
    if not any(size > _STIFFER * least and image.size for size, least, image, _ in parts):
        return None
    stiffer = [
        (size - least, image, square) for size, least, image, square in parts if size > least
    ]
    images = np.hstack([np.sqrt(b) * image for b, image, _ in stiffer])
    roots = np.zeros((images.shape[1], images.shape[1]))
    size = len(stiffer[0][2])
    for number, (_, _, square) in enumerate(stiffer):
        own = slice(number * size, (number + 1) * size)
        sizes, axes = np.linalg.eigh(square)
        rounding = np.finfo(float).eps * size * max(float(sizes[-1]), 0.0)
        roots[own, own] = np.sqrt(np.maximum(sizes, 0.0) + rounding)[:, None] * axes.T
    q, _ = np.linalg.qr(np.vstack([images, roots]))
    forces, rest = q[: len(images)], q[len(images) :]
    sizes, axes = np.linalg.eigh(rest.T @ rest)
    left = np.sqrt(np.clip(sizes, 0.0, 1.0))
    return StiffNorm(forces, (axes / (1 + left)) @ axes.T)
