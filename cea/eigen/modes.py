"""Modes of a complex eigenvalue analysis."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.block_products import all_inner, column_blocks, times
from cea.eigen.classify import cannot_grow
from cea.eigen.errors import Eigenpairs, LeftVectors
from cea.eigen.matching import DEGENERATE, group
from cea.eigen.pencil import POWERS, Matrices, Pencil
from cea.eigen.shift_invert import MARGIN
from cea.eigen.spectrum import Spectrum, Window
from cea.errors import ConvergenceError, InputError, ResultWarning

_NO_MODE = 0.5
"""Uncertainty of lambda relative to its speed above which a mode counts as lost to rounding."""


@dataclass(frozen=True)
class Modes(Spectrum):
    """Eigenvalues with their eigenvectors, the pencil and its parameters.

    Parameters
    ----------
    vectors
        Eigenvectors x with x^H M x = 1, the rows of this rank, shape (n_local, n).
    forces
        Their multipliers, those of contacts first, shape (multipliers of this rank, n).
    left
        Left eigenvectors; None where they were not requested.
    template
        PETSc vector with the layout of the eigenvectors.
    pencil, values
        The pencil, and the values of its parameters.
    """

    vectors: Complexes
    forces: Complexes
    left: LeftVectors | None
    template: Any
    pencil: Pencil
    values: Mapping[str, float]

    __repr__ = Spectrum.__str__

    def __getitem__(self, modes: Ints) -> "Modes":
        """Return some of the modes, by their indices from zero."""
        return replace(
            self,
            eigenvalues=self.eigenvalues[modes],
            residuals=self.residuals[modes],
            conditions=self.conditions[modes],
            growth_uncertainties=self.growth_uncertainties[modes],
            bounded=None if self.bounded is None else self.bounded[modes],
            vectors=_columns(self.vectors, modes),
            forces=self.forces[:, modes],
            left=self.left[modes] if self.left is not None else None,
        )

    def vector(self, mode: int) -> tuple[Any, Any]:
        """Return the real and the imaginary part of an eigenvector as PETSc vectors."""
        real, imaginary = self.template.duplicate(), self.template.duplicate()
        real.array[:] = self.vectors[:, mode].real
        imaginary.array[:] = self.vectors[:, mode].imag
        return real, imaginary

    def sensitivity(self, parameter: str) -> Complexes:
        """Return the derivatives of the eigenvalues in a parameter of the pencil, shape (n,).

        d lambda / dt = - y^H (lambda^2 dM/dt + lambda dD/dt + dK/dt) x / y^H (2 lambda M + D) x
        with left vectors y and D of damping and rotation.
        For a multiple eigenvalue they are the derivatives of the eigenvalues into which it splits,
        in any order. Infinite at a coalescence, and NaN at lambda = 0.

        Parameters
        ----------
        parameter
            Name of the parameter, e.g. ``contacts.pad_disc.mu``.

        Raises
        ------
        InputError
            When there is no such parameter, or no left vectors were requested.
        """
        name, fixed = self.pencil.parameter(parameter).name, self.pencil.parameter(parameter).fixed
        if fixed:
            raise InputError(name, self.values[name], "fixed: modal damping was found at it")
        if self.left is None:
            raise InputError("left", False, "True in the solve, for sensitivities")
        lam, x, y, values = self.eigenvalues, self.vectors, self.left, self.values
        change: Complexes = np.zeros((len(lam), len(lam)), dtype=complex)
        comm, first = self.pencil.comm, 0
        for role, coefficient, product in self.pencil.products():
            if slope := coefficient.derivative(name, values):
                for block in column_blocks(len(lam)):
                    projected = all_inner(y.vectors, product(x[:, block]), comm)
                    change[:, block] += slope * lam[block] ** POWERS[role] * projected
        for of_contact in self.pencil.forces:
            last = first + of_contact.closure.getLocalSize()[0]
            f, g = self.forces[first:last], y.forces[first:last]
            slope = of_contact.friction.derivative(name, values)
            if slope and of_contact.slip is not None:
                change -= slope * all_inner(times(of_contact.slip, y.vectors), f, comm)
            if slope := of_contact.inverse_stiffness.derivative(name, values):
                change -= slope * all_inner(g, times(of_contact.compliance, f), comm)
            first = last
        moved = np.diag(change).copy()
        for members in group(lam, DEGENERATE):
            if len(members) > 1:
                moved[members] = np.linalg.eigvals(change[np.ix_(members, members)])
        with np.errstate(divide="ignore", invalid="ignore"):
            return -moved / (2 * lam)


def modes_of(
    pencil: Pencil,
    values: Mapping[str, float],
    matrices: Matrices,
    pairs: Eigenpairs,
    left: LeftVectors | None,
    window: Window,
) -> Modes:
    """Return the modes with Im lambda >= 0 in the window, from eigenpairs.

    ConvergenceError when modes are lost to rounding.
    """
    end = 2 * np.pi * window.max_frequency
    if matrices.quadratic:
        eigenvalues, uncertainties = pairs.values, pairs.uncertainties
        real = np.abs(eigenvalues.imag) <= np.minimum(uncertainties, MARGIN * end)
        eigenvalues = np.where(real, eigenvalues.real, eigenvalues)
        conditions = np.maximum(2 * np.abs(eigenvalues) * pairs.slopes, 1.0)
        bounded = np.zeros(len(eigenvalues), dtype=bool)
        if matrices.conservative:
            bounded = cannot_grow(-1j * eigenvalues, uncertainties, symmetric=False)
        inside = (eigenvalues.imag >= 0) & (eigenvalues.imag <= window.upper)
        rigid = np.abs(eigenvalues) <= uncertainties
        if window.min_growth is not None:
            inside &= (eigenvalues.real >= window.min_growth) | rigid
    else:
        kappa, errors = pairs.values, pairs.uncertainties
        eigenvalues = np.sqrt(-kappa).astype(complex)
        eigenvalues = np.where(eigenvalues.imag < 0, -eigenvalues, eigenvalues) + 0j
        # Rounding may split a multiple negative kappa into a complex pair: both grow.
        diverges = (kappa.real < 0) & (np.abs(kappa.imag) <= errors)
        growing = np.abs(eigenvalues.real) + 1j * eigenvalues.imag
        eigenvalues = np.where(diverges, growing, eigenvalues)
        uncertainties, conditions = uncertainties_of(eigenvalues, errors), pairs.conditions
        bounded = cannot_grow(kappa, errors, symmetric=matrices.symmetric)
        inside = eigenvalues.imag <= end
    order = np.lexsort((eigenvalues.real, eigenvalues.imag))
    order = order[inside[order]]
    modes = Modes(
        eigenvalues=eigenvalues[order],
        residuals=pairs.residuals[order],
        conditions=conditions[order],
        growth_uncertainties=uncertainties[order],
        bounded=bounded[order],
        vectors=_columns(pairs.vectors, order),
        forces=pairs.forces[:, order],
        left=left[order] if left is not None else None,
        template=matrices.stiffness.createVecRight(),
        window=window,
        pencil=pencil,
        values=values,
    )
    speeds = np.maximum(np.abs(eigenvalues), modes.slowest)
    lost = int(np.sum(uncertainties > _NO_MODE * speeds))  # guard eigenvalues included
    if lost:
        worst = float((uncertainties / speeds).max())
        raise ConvergenceError(
            f"{lost} of {len(eigenvalues)} modes are lost to rounding, with errors of up to "
            f"{worst:.1e} times abs(lambda): stiffnesses, sizes or elements of this system differ "
            "too much",
            best=modes,
        )
    return replace(modes, warnings=warnings_of(modes))


def up_to(wider: Modes, max_frequency: float, min_growth: float | None) -> Modes:
    """Return the modes up to a frequency of a search that went beyond it."""
    beyond = wider.frequencies > max_frequency
    grow = beyond & (wider.growth_rates > wider.growth_uncertainties)
    pairs = np.column_stack([wider.frequencies, wider.growth_rates])[grow]
    window = replace(
        wider.window, max_frequency=max_frequency, growing_above=tuple(map(tuple, pairs.tolist()))
    )
    kept = ~beyond
    if window.min_growth is not None and min_growth is None:  # the default is relative to the end
        least = window.min_growth * max_frequency / wider.window.max_frequency
        window, kept = replace(window, min_growth=least), kept & (wider.growth_rates >= least)
    modes = replace(wider[np.flatnonzero(kept)], window=window)
    return replace(modes, warnings=warnings_of(modes))


def _columns(vectors: Complexes, order: Ints) -> Complexes:
    """Return columns in the given order, without a copy where they already have it."""
    number = len(order)
    return vectors[:, :number] if np.array_equal(order, np.arange(number)) else vectors[:, order]


def uncertainties_of(eigenvalues: Complexes, errors: Floats) -> Floats:
    """Return errors of lambda (1/s) from errors of lambda^2: half in relative terms, or the root.

    The root bounds the error where lambda^2 is zero within its error.
    """
    known = np.isfinite(errors)
    some = np.where(known, errors, 0.0)
    sizes = np.maximum(np.abs(eigenvalues), np.sqrt(some))
    errors = some / np.maximum(2 * sizes - np.sqrt(some), np.finfo(float).tiny)
    return np.where(known, errors, np.inf)


def warnings_of(modes: Modes) -> tuple[ResultWarning, ...]:
    """Return the warnings about modes: an incomplete window, and large uncertainties."""
    warnings, window = [], modes.window
    if np.isfinite(window.max_frequency) and not window.complete:
        message = (
            "the sign of a determinant shows that a mode with real lambda is missing"
            if window.odd
            else f"modes that grow faster than {window.max_growth:.3g} 1/s are not excluded"
        )
        data = {"max_growth": window.max_growth, "odd": window.odd}
        warnings.append(ResultWarning("window-not-complete", message, data))
    unsure = np.flatnonzero(~modes.trusted)
    if len(unsure):
        worst = float((modes.growth_uncertainties / modes.speeds)[unsure].max())
        warnings.append(
            ResultWarning(
                "not-trusted",
                f"{len(unsure)} modes have errors of up to {worst:.1e} times abs(lambda)",
                {"modes": (unsure + 1).tolist(), "worst": worst},
            )
        )
    return tuple(warnings)
