"""Galerkin method of high degree for two bodies in sliding contact, in double precision.

Basis functions are products of functions of two coordinates (axes), so stiffness and mass are sums
of Kronecker products. The contact force f is an unknown in the trace space of the interface, which
both bodies share. With matching traces this equals the penalty form, and p may be infinite.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigs, splu

from cea.errors import ConvergenceError
from exact_cea.material import Material
from exact_cea.numbers import check_window
from exact_cea.spectral import Axis, Single

Term = tuple[complex, int, str, str]
"""Coefficient, displacement component, table of the first and of the second axis."""

_RIGID = 1e-11  # abs(omega^2), relative to scale^2, below which a mode is a rigid body mode

Strain = Sequence[Sequence[Term]]
"""Terms of the strains 11, 22, 33, 2 * 12, 2 * 13, 2 * 23."""


@dataclass(frozen=True)
class GalerkinBody:
    """Body on a tensor product of two axes."""

    material: Material
    axes: tuple[Axis, Axis | Single]
    components: int  # number of displacement components
    strain: Strain  # in terms of the components
    # functions fixed at zero, by component, shape (size of axis 1, size of axis 2)
    fixed: Mapping[int, NDArray[np.bool_]]
    interface: tuple[int, int]  # which axis is normal to it, and its index there, 0 or -1

    @property
    def free(self) -> NDArray[np.intp]:
        """Indices of the functions that are not fixed."""
        shape = self.axes[0].size, self.axes[1].size
        held = np.stack([self.fixed.get(i, np.zeros(shape, bool)) for i in range(self.components)])
        return np.flatnonzero(~held.ravel())

    def matrices(self) -> tuple[sparse.csr_array, sparse.csr_array]:
        """Return stiffness (Hermitian) and mass of the free functions."""
        L, G = (float(value) for value in self.material.lame)
        elasticity = np.diag([2 * G] * 3 + [G] * 3)
        elasticity[:3, :3] += L
        blocks: dict[tuple[int, int], sparse.csr_array] = {}
        for i, j in np.argwhere(elasticity).tolist():
            for c, u, x, y in self.strain[i]:
                for d, v, s, t in self.strain[j]:
                    part = (elasticity[i, j] * np.conj(c) * d) * sparse.kron(
                        self.axes[0].gram(x, s), self.axes[1].gram(y, t), format="csr"
                    )
                    blocks[u, v] = blocks[u, v] + part if (u, v) in blocks else part
        n = range(self.components)
        K = sparse.block_array([[blocks.get((u, v)) for v in n] for u in n], format="csr")
        one = float(self.material.rho) * sparse.kron(
            self.axes[0].gram("value", "value"), self.axes[1].gram("value", "value")
        )
        M = sparse.block_diag([one] * self.components, format="csr")
        free = self.free
        K = (K + K.conj().T) / 2
        return K[free][:, free], M[free][:, free]

    def trace(self, component: int) -> sparse.csr_array:
        """Return the trace of a component on the interface, as a matrix on the free functions."""
        normal, end = self.interface
        size = self.axes[normal].size
        pick = sparse.csr_array(([1.0], ([0], [end % size])), shape=(1, size))
        along = sparse.eye_array(self.axes[1 - normal].size)
        parts = (pick, along) if normal == 0 else (along, pick)
        row = [sparse.csr_array((along.shape[0], self.axes[0].size * self.axes[1].size))]
        whole = row * component + [sparse.kron(*parts)] + row * (self.components - component - 1)
        return sparse.hstack(whole, format="csr")[:, self.free]


@dataclass(frozen=True)
class GalerkinContact:
    """Two bodies with the same basis along the interface, in frictional contact."""

    a: GalerkinBody
    b: GalerkinBody
    normal: tuple[int, float]  # component along n, with its sign
    tangent: tuple[int, float]  # component along k, with its sign
    p: float  # contact stiffness, may be infinite
    # friction coefficient, a number or a function of the coordinate along the interface
    mu: float | Callable[[NDArray[np.float64]], NDArray[np.float64]]

    def pencil(self) -> tuple[sparse.csc_array, sparse.csc_array]:
        """Return (A, B) of ``A x = omega^2 B x``; the last unknowns are the contact force."""
        K_a, M_a = self.a.matrices()
        K_b, M_b = self.b.matrices()
        axis = self.a.axes[1 - self.a.interface[0]]
        plain = axis.gram("value", "value")
        if not callable(self.mu):
            weighted = self.mu * plain
        elif isinstance(axis, Axis):
            weighted = axis.gram("value", "value", self.mu(axis.points))
        else:
            weighted = float(self.mu(np.zeros(1))[0]) * plain
        (n, n_sign), (k, k_sign) = self.normal, self.tangent
        gap = n_sign * sparse.hstack([self.a.trace(n), -self.b.trace(n)])
        slip = k_sign * sparse.hstack([self.a.trace(k), -self.b.trace(k)])
        G = plain @ gap
        A = sparse.block_array(
            [
                [sparse.block_diag([K_a, K_b]), G.T - slip.T @ weighted],
                [G, -plain / self.p],
            ],
            format="csc",
        )
        B = sparse.block_diag([M_a, M_b, sparse.csr_array(plain.shape)], format="csc")
        # Scale diagonals to one (Schur complement for the force): units differ by 20 decades.
        stiffness = np.concatenate([K_a.diagonal(), K_b.diagonal()]).real
        schur = (G.multiply(G) @ (1 / stiffness)) + plain.diagonal() / self.p
        scaling = sparse.diags_array(1 / np.sqrt(np.concatenate([stiffness, schur])))
        return sparse.csc_array(scaling @ A @ scaling), sparse.csc_array(scaling @ B @ scaling)


def lowest(contact: GalerkinContact, count: int, scale: float) -> NDArray[np.complex128]:
    """Return the lowest eigenvalues lambda with Im >= 0, by ARPACK about a negative shift.

    They are sorted by frequency, then growth. Eigenvalues of rigid body modes are set to zero.
    """
    A, B = contact.pencil()
    shift = -(scale**2) / 4
    wanted = count + max(10, count // 2)
    if wanted > A.shape[0] - 2:
        raise ConvergenceError(f"{A.shape[0]} unknowns are too few for {wanted} eigenvalues")
    factor = splu(
        sparse.csc_array(A - shift * B),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )
    operator = LinearOperator(
        A.shape, matvec=lambda x: factor.solve(B @ np.ravel(x)), dtype=A.dtype
    )
    start = np.random.default_rng(1).standard_normal(A.shape[0]).astype(A.dtype)
    basis = min(3 * wanted, A.shape[0])
    inverse = eigs(operator, wanted, which="LM", v0=start, ncv=basis, return_eigenvectors=False)
    omega2 = shift + 1 / inverse
    rigid = abs(omega2) < _RIGID * scale**2
    values = 1j * np.sqrt(np.where(rigid, 0, omega2).astype(complex))
    values = np.where(values.imag < 0, -values, values)
    return values[np.lexsort((values.real, np.round(values.imag, 12)))][:count]


def lowest_in(
    contact: GalerkinContact,
    scale: float,
    max_frequency: float | None = None,
    count: int | None = None,
) -> NDArray[np.complex128]:
    """Return all eigenvalues with ``0 <= Im <= max_frequency``, or the lowest ``count``."""
    if max_frequency is None:
        return lowest(contact, count or 1, scale)
    wanted = 20
    values = lowest(contact, wanted, scale)
    while values[-1].imag <= max_frequency:
        wanted *= 2
        values = lowest(contact, wanted, scale)
    return values[values.imag <= max_frequency]


def converged(
    contact: Callable[[bool], GalerkinContact],
    scale: float,
    count: int | None = None,
    max_frequency: float | None = None,
) -> tuple[NDArray[np.complex128], list[int]]:
    """Return eigenvalues of a fine discretisation and the digits shared with a coarse one."""
    check_window(max_frequency, count)
    values = lowest_in(contact(True), scale, max_frequency, count)
    others = lowest(contact(False), len(values) + 2, scale)
    apart = np.array([abs(others - value).min() for value in values])
    size = np.where(values == 0, scale, abs(values))
    digits = -np.log10(np.maximum(apart / size, 1e-14))
    return values, [max(0, int(d)) for d in digits]
