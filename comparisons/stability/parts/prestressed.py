"""Dense matrices of pressed layers on bilinear elements, their prestress too, by tensor products.

On a rectangle every matrix is a product of those of one dimension, S = int N' N', M = int N N and
D = int N' N, and the stresses of layers pressed between rollers are uniform: nothing is taken from
the program.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag, eigh

from cea.arrays import Complexes, Floats

_WIDTH = 2.0


@dataclass(frozen=True)
class Layer:
    """A layer between rollers at its ends.

    Parameters
    ----------
    E, nu, rho
        Material.
    height
        Height (m).
    elements
        Elements along x and y.
    """

    E: float
    nu: float
    rho: float
    height: float
    elements: tuple[int, int]

    def matrices(self) -> tuple[Floats, Floats, Floats]:
        """K, M and the geometric stiffness of a pressure 1 along y, dofs (component, x, y)."""
        lam = self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))
        mu = self.E / (2 * (1 + self.nu))
        Sx, Mx, Dx = _line(self.elements[0], _WIDTH)
        Sy, My, Dy = _line(self.elements[1], self.height)
        along_x, along_y, mass = np.kron(Sx, My), np.kron(Mx, Sy), np.kron(Mx, My)
        mixed = lam * np.kron(Dx, Dy.T) + mu * np.kron(Dx.T, Dy)
        K = np.block(
            [
                [(lam + 2 * mu) * along_x + mu * along_y, mixed],
                [mixed.T, mu * along_x + (lam + 2 * mu) * along_y],
            ]
        )
        squeezed = -(self.nu / (1 - self.nu) * along_x + along_y)
        return K, block_diag(*[self.rho * mass] * 2), block_diag(squeezed, squeezed)

    def dof(self, component: int, i: int, j: int) -> int:
        """Number of a dof."""
        columns, rows = (count + 1 for count in self.elements)
        return (component * columns + i) * rows + j


def _line(elements: int, length: float) -> tuple[Floats, Floats, Floats]:
    """S, M and D of linear elements on a line."""
    S, M, D = (np.zeros((elements + 1, elements + 1)) for _ in range(3))
    h = length / elements
    for e in range(elements):
        at = np.ix_([e, e + 1], [e, e + 1])
        S[at] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / h
        M[at] += np.array([[2.0, 1.0], [1.0, 2.0]]) * h / 6
        D[at] += np.array([[-0.5, -0.5], [0.5, 0.5]])
    return S, M, D


def _pressed(upper: Layer, lower: Layer, p: float) -> tuple[Floats, Floats, Floats]:
    """K, M and geometric stiffness of a pressure 1 of both layers on their free dofs."""
    K, M, K_geo = (
        block_diag(*pair) for pair in zip(upper.matrices(), lower.matrices(), strict=True)
    )
    columns = upper.elements[0] + 1
    second = 2 * columns * (upper.elements[1] + 1)
    top = lower.elements[1]
    facing = np.zeros((columns, len(K)))
    for i in range(columns):
        facing[i, upper.dof(1, i, 0)] = -1.0
        facing[i, second + lower.dof(1, i, top)] = 1.0
    K += p * facing.T @ _line(upper.elements[0], _WIDTH)[1] @ facing
    held = [upper.dof(0, i, j) for i in (0, columns - 1) for j in range(upper.elements[1] + 1)]
    held += [upper.dof(0, i, upper.elements[1]) for i in range(columns)]
    held += [second + lower.dof(0, i, j) for i in (0, columns - 1) for j in range(top + 1)]
    held += [second + lower.dof(c, i, 0) for c in (0, 1) for i in range(columns)]
    free = np.setdiff1d(np.arange(len(K)), held)
    return tuple(matrix[np.ix_(free, free)] for matrix in (K, M, K_geo))


def buckling_pressure(upper: Layer, lower: Layer, p: float) -> float:
    """Least pressure (N/m^2) at which the layers have no stiffness left, p that of the contact."""
    K, _, K_geo = _pressed(upper, lower, p)
    return float(1 / eigh(-K_geo, K, eigvals_only=True)[-1])


def prestressed_eigenvalues(upper: Layer, lower: Layer, p: float, pressure: float) -> Complexes:
    """Lambda (1/s) of every mode under a pressure (N/m^2); of buckled ones that which grows."""
    K, M, K_geo = _pressed(upper, lower, p)
    squares = eigh(K + pressure * K_geo, M, eigvals_only=True)
    return np.where(squares < 0, np.sqrt(np.abs(squares)), 1j * np.sqrt(np.abs(squares)))
