"""Full solves as plain arrays, and as blocks of real vectors that a basis takes in."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.modes import Modes
from cea.errors import ResultWarning
from cea.reduced.basis import InnerProduct


@dataclass(frozen=True)
class Snapshot:
    """Modes of a full solve with left vectors, the rows of this rank.

    lambda, what its errors are relative to, errors (1/s) and condition numbers, shape (n,);
    eigenvectors and contact forces of both sides, shape (rows, n); whether its window was shown to
    be complete, and up to which growth (1/s) it is; what it must be read with.
    """

    point: Mapping[str, float]
    eigenvalues: Complexes
    speeds: Floats
    uncertainties: Floats
    conditions: Floats
    right: Complexes
    left: Complexes
    forces: Complexes
    left_forces: Complexes
    complete: bool
    max_growth: float
    warnings: tuple[ResultWarning, ...] = ()

    @classmethod
    def of(
        cls,
        point: Mapping[str, float],
        modes: Modes,
        warnings: tuple[ResultWarning, ...] | None = None,
    ) -> "Snapshot":
        """What a basis needs of modes that have left vectors."""
        assert modes.left is not None
        return cls(
            {name: float(value) for name, value in point.items()},
            modes.eigenvalues,
            modes.speeds,
            modes.growth_uncertainties,
            modes.conditions,
            modes.vectors,
            modes.left.vectors,
            modes.forces,
            modes.left.forces,
            modes.window.complete,
            float(modes.window.max_growth),
            tuple(modes.warnings) if warnings is None else warnings,
        )

    def plain(self) -> dict[str, Any]:
        """It as plain data, without the vectors."""
        return {
            "point": dict(self.point),
            "complete": bool(self.complete),
            "max_growth": self.max_growth if np.isfinite(self.max_growth) else None,
            "warnings": [warning.plain() for warning in self.warnings],
        }

    def real_vectors(self, norm: InnerProduct, *, damped: bool) -> Floats:
        """States of real and imaginary parts of all vectors, each complex one of length one.

        Of conjugate pairs of kappa one is enough; damped pencils have none. Phases are such that
        real parts are as long as can be.
        """
        one = ((-(self.eigenvalues**2)).imag >= 0) | damped
        parts = [_parts(norm, self.right[:, one])]
        if norm.comm.allreduce(not np.array_equal(self.left, self.right)):
            parts.append(_parts(norm, self.left[:, one]))
        return np.hstack(parts)

    def real_forces(self) -> Floats:
        """States of real and imaginary parts of all contact forces."""
        both = self.forces, self.left_forces
        parts = np.hstack([part for each in both for part in (each.real, each.imag)])
        return np.vstack([np.zeros((len(self.right), parts.shape[1])), parts])


def _parts(norm: InnerProduct, vectors: Complexes) -> Floats:
    square = norm.comm.allreduce(np.einsum("ij,ij->j", vectors, vectors))
    vectors = vectors * np.exp(-0.5j * np.angle(square))
    vectors = np.pad(vectors, ((0, norm.rows - len(vectors)), (0, 0)))
    real, imaginary = np.asfortranarray(vectors.real), np.asfortranarray(vectors.imag)
    of_imaginary = norm.lengths(imaginary)
    lengths = np.hypot(norm.lengths(real), of_imaginary)
    turning = of_imaginary > np.finfo(float).eps * lengths
    return np.hstack([real / lengths, (imaginary / lengths)[:, turning]])
