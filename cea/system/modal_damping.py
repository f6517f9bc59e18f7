"""Modal damping as pieces of a pencil: elastic modes of a body alone, and what damps them.

By the path of the body in a scene, ``bodies.<name>``, the parameter is ``.damping.modal.ratio``, or
``.damping.modal.ratios``, a factor on these.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import eigh

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.block_products import all_inner, times
from cea.eigen.coefficients import Coefficient, Parameter
from cea.eigen.driver import EigenSolver
from cea.eigen.pencil import Pencil
from cea.eigen.search import Search, nearest_plan
from cea.eigen.shifted import count_below
from cea.errors import ConvergenceError, InputError, require
from cea.matrices import diagonal_of
from cea.motion import ModalDamping
from cea.petsc import MPI
from cea.timing import StageTimer

_SAME = 1e-8  # relative distance up to which frequencies are those of one multiple eigenvalue
_MOST = 2000  # most modes of a body that are damped one by one
_RIGID = 10.0  # frequency relative to its uncertainty up to which a motion is rigid, or lost
_RIGID_MOTIONS = 6  # most rigid motions of a body in one piece
_BELOW = 1e-9
"""Square of a frequency that no elastic mode need be below, relative to the largest."""
_BEYOND = 1e-6  # what is searched beyond the last mode asked for, relative to its frequency


@dataclass(frozen=True)
class _OfTheseModes:
    """A coefficient of modes that are found anew where the material of their body changes."""

    coefficient: Coefficient  # the coefficient, as long as it does not
    found_at: Mapping[str, float]  # E and rho of the body, by their names

    @property
    def names(self) -> frozenset[str]:
        """Parameters it depends on."""
        return self.coefficient.names | frozenset(self.found_at)

    def times(self, name: str) -> "_OfTheseModes":
        """It times one more parameter."""
        return _OfTheseModes(self.coefficient.times(name), self.found_at)

    def at(self, values: Mapping[str, float]) -> float:
        """Value at given parameters; refused where the modes would be others."""
        for name, found_at in self.found_at.items():
            same, allowed = values[name] == found_at, f"{found_at:g}, where damped modes were found"
            require(same, name, values[name], allowed)
        return self.coefficient.at(values)

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Derivative in one parameter; refused where the modes would move."""
        stays = name not in self.found_at
        require(stays, name, values[name], "left as it is: damped modes move with it")
        return self.coefficient.derivative(name, values)


@dataclass(frozen=True)
class DampedModes:
    """Modes of a body that are damped: sum_j 2 zeta_j omega_j (M phi_j) (M phi_j)^T."""

    # phi with phi^T M phi = 1, and M phi, the rows of this rank, shape (n_local, n)
    vectors: Floats
    images: Floats
    weights: Floats  # 2 zeta omega (1/s) at a parameter of 1, shape (n,)
    coefficient: Coefficient | _OfTheseModes  # how it depends on the ratio, on E and on rho


def damped_modes(path: str, body: Body, damping: ModalDamping) -> DampedModes:
    """Modes of a body that modal damping damps; rigid motions are none of them."""
    counted = damping.ratios if damping.end is None and damping.ratios is not None else ()
    try:
        frequencies, reach, vectors = _elastic_modes(path, body, damping.end, len(counted))
    except ConvergenceError as error:
        raise ConvergenceError(f"modes of {path} for its damping: {error}") from error
    given, place = f"{len(counted)} ratios", f"{path}.damping.modal.ratios"
    allowed = f"at most {len(frequencies)}: all elastic modes of the body"
    require(len(counted) <= len(frequencies), place, given, allowed)
    factors = _factors(path, damping, frequencies, np.maximum(_SAME * frequencies, reach))
    damped = factors > 0
    vectors, weights = vectors[:, damped], (4 * np.pi * factors * frequencies)[damped]
    coefficient = _coefficient(path, body, damping)
    return DampedModes(vectors, times(body.mass(), vectors), weights, coefficient)


def modal_parameter(path: str, damping: ModalDamping) -> Parameter:
    """The parameter of modal damping; path and damping as for :func:`damped_modes`."""
    if damping.ratio is not None:
        return Parameter(f"{path}.damping.modal.ratio", damping.ratio)
    return Parameter(f"{path}.damping.modal.ratios", 1.0, "a factor on the ratios")


def _coefficient(path: str, body: Body, damping: ModalDamping) -> Coefficient | _OfTheseModes:
    """How modal damping depends on the ratio, on E and on rho.

    Modes that are counted stay the same where E and rho change a body without springs, and
    2 omega_j (M phi_j) (M phi_j)^T goes with the root of E rho.
    """
    material = {f"{path}.material.rho": float(body.material.rho or 0)}
    if (E := body.material.constants.get("E")) is not None:
        material[f"{path}.material.E"] = E
    ratio = {modal_parameter(path, damping).name: (1.0, 1.0)}
    if damping.end is None and body.spring_stiffness() is None:
        return Coefficient(ratio | {name: (value, 0.5) for name, value in material.items()})
    return _OfTheseModes(Coefficient(ratio), material)


def _factors(path: str, damping: ModalDamping, frequencies: Floats, reach: Floats) -> Floats:
    """Damping ratios of elastic modes relative to the parameter, shape (n,).

    Modes that share a frequency, within the reach of both, have the same: C must not depend on
    which vectors were found.
    """
    apart = np.diff(frequencies) > reach[1:] + reach[:-1]
    groups = np.concatenate([[0], np.cumsum(apart)])[: len(reach)]
    means = np.bincount(groups, frequencies) / np.bincount(groups)
    if damping.end is not None:
        return damping.factors_at(means)[groups]
    factors = damping.factors_at(frequencies)
    for group, frequency in enumerate(means):
        members = np.flatnonzero(groups == group)
        if np.ptp(factors[members]) > 0:
            allowed = (
                f"the same ratio for elastic modes {members[0] + 1} to {members[-1] + 1}, which "
                f"share the frequency {frequency:.6g} Hz"
            )
            raise InputError(f"{path}.damping.modal.ratios", damping.ratios, allowed)
    return factors


def _elastic_modes(
    path: str, body: Body, end: float | None, wanted: int
) -> tuple[Floats, Floats, Floats]:
    """Every elastic mode of a body up to a frequency, or so many, and perhaps some beyond.

    Rising frequencies and what they may be off by (Hz), shape (n,), and vectors phi with
    phi^T M phi = 1, the rows of this rank.
    """
    with EigenSolver(Pencil.of(body.stiffness(), body.mass())) as solver:
        matrices = solver.matrices()
        # of the size of the largest kappa (1/s^2)
        ratios = diagonal_of(matrices.stiffness) / diagonal_of(matrices.mass)
        largest = float(body.comm.allreduce(ratios.max(initial=0.0), MPI.MAX))
        least, highest = (float(np.sqrt(part * largest)) / (2 * np.pi) for part in (_BELOW, 1.0))
        if end is None:  # so many elastic modes, and one more if any
            count = min(wanted + 1 + _RIGID_MOTIONS, matrices.size)
            search = Search(matrices, np.inf, solver.options, StageTimer())
            try:
                found = search.run(nearest_plan(search, -_BELOW * largest, count))
                kappa = np.sort(found.eigenvalues.real)
            finally:
                search.free()
            end = float(np.sqrt(kappa[count - 1])) / (2 * np.pi)
        end = max((1 + _BEYOND) * end, least)
        modes_below = count_below(matrices, (2 * np.pi * end) ** 2)
        if modes_below > _MOST:
            allowed = f"at most {_MOST} modes that are damped one by one; Rayleigh damping for more"
            raise InputError(f"{path}.damping.modal", f"{modes_below} up to {end:g} Hz", allowed)
        if modes_below == matrices.size:  # an end that is not far beyond all modes
            below = partial(count_below, matrices)
            while highest < end and below((2 * np.pi * highest) ** 2) < matrices.size:
                highest *= 2
            end = min(highest, end)
        modes = solver.solve(end)
    uncertainties = modes.growth_uncertainties / (2 * np.pi)
    elastic = modes.frequencies > _RIGID * uncertainties
    if lost := int((~elastic & (modes.frequencies > least)).sum()):
        raise ConvergenceError(f"{lost} of {len(modes)} modes are lost to rounding", best=modes)
    # Rayleigh-Ritz in the space that they span.
    vectors = modes.vectors.real
    form, gram = (
        all_inner(vectors, times(each, vectors), each.comm)
        for each in (body.stiffness(), body.mass())
    )
    kappa, turn = eigh(form, gram)
    frequencies = np.sqrt(np.maximum(kappa, 0.0)) / (2 * np.pi)
    return frequencies[elastic], uncertainties[elastic], (vectors @ turn)[:, elastic]
