"""Modal damping as a piece of a pencil: the modes of a body alone, and what damps them.

By the path of the body in a scene, ``bodies.<name>``, the parameter is ``.damping.modal.ratio``, or
``.damping.modal.ratios``, a factor on these.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from cea.body import Body, Floats
from cea.damping import ModalDamping
from cea.eigen.blocks import all_inner, image_of
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.low_rank import LowRank, LowRankTerm
from cea.eigen.modes import Modes
from cea.eigen.nearest import NearestSearch
from cea.eigen.parameters import Coefficient, Dependence, Parameter
from cea.eigen.pencil import Matrices, Pencil, release
from cea.eigen.shifted import Shifted, count_below
from cea.errors import ConvergenceError, InputError
from cea.matrices import destroy
from cea.timing import StageTimer

_RIGID = 10.0
"""Angular frequency relative to its uncertainty up to which a motion is rigid."""
_SAME = 1e-8
"""Relative distance up to which frequencies are those of one multiple eigenvalue."""
_MOST = 2000
"""Most modes of a body that are damped one by one."""
_RIGID_MOTIONS = 6
_BELOW = 1e-9
"""Shift below all modes, relative to the largest ratio of diagonal entries of K and M."""
_BEYOND = 1e-6
"""What is searched beyond the last damped mode, relative to its frequency."""
_TOLERANCE, _MOST_RESTARTS = 1e-8, 200
"""Of the search for the frequency up to which modes are solved for."""


@dataclass(frozen=True)
class _OfTheseModes:
    """A coefficient of modes that are found anew where the material of their body changes.

    Parameters
    ----------
    coefficient
        The coefficient, as long as it does not.
    found_at
        E and rho of the body, by their names.
    """

    coefficient: Coefficient
    found_at: Mapping[str, float]

    @property
    def names(self) -> frozenset[str]:
        """Parameters it depends on."""
        return self.coefficient.names | frozenset(self.found_at)

    def at(self, values: Mapping[str, float]) -> float:
        """Value at given parameters; refused where the modes would be others."""
        for name, value in self.found_at.items():
            if values[name] != value:
                raise _changed(name, values[name], value)
        return self.coefficient.at(values)

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Derivative in one parameter; refused where the modes would move."""
        if name in self.found_at:
            raise _changed(name, values[name], self.found_at[name])
        return self.coefficient.derivative(name, values)


def _changed(name: str, value: float, found_at: float) -> InputError:
    allowed = (
        f"{found_at:g}, at which the modes were found that are damped; a scene changed there is "
        "assembled anew"
    )
    return InputError(name, value, allowed)


def modal_terms(path: str, body: Body, damping: ModalDamping, first: int) -> Iterator[LowRankTerm]:
    """Modal damping of a body, sum_j 2 zeta_j omega_j (M phi_j) (M phi_j)^T; none of rigid motions.

    Parameters
    ----------
    path
        Path of the body in a scene.
    body
        The body.
    damping
        What damps it.
    first
        Number of its first row among the unknowns of this rank.

    Raises
    ------
    InputError
        When more ratios are given than the body has modes, modes of one frequency are given
        different ones, or modes are too many to be damped one by one.
    ConvergenceError
        When the modes of the body are not found.
    """
    modes = _modes(path, body, damping)
    elastic = modes.frequencies > _rigid_up_to(modes)
    frequencies, vectors = _rayleigh_ritz(body, modes.vectors.real)
    frequencies, vectors = frequencies[elastic], vectors[:, elastic]
    groups = _groups(frequencies, modes.growth_uncertainties[elastic] / (2 * np.pi))
    if len(damping.ratios or ()) > len(frequencies) and damping.end is None:
        allowed = f"at most {len(frequencies)}: all elastic modes of the body"
        raise InputError(
            f"{path}.damping.modal.ratios", f"{len(damping.ratios or ())} ratios", allowed
        )
    factors = _factors(path, damping, frequencies, groups)
    damped = factors > 0
    weights = (4 * np.pi * factors * frequencies)[damped]
    piece = LowRank(image_of(body.mass(), vectors[:, damped]), weights, first)
    yield LowRankTerm(piece, _coefficient(path, body, damping))


def modal_parameters(path: str, damping: ModalDamping) -> Iterator[Parameter]:
    """The parameter of modal damping; path and damping as for :func:`modal_terms`."""
    if damping.ratio is not None:
        yield Parameter(f"{path}.damping.modal.ratio", damping.ratio)
    else:
        yield Parameter(f"{path}.damping.modal.ratios", 1.0, "a factor on the ratios")


def _coefficient(path: str, body: Body, damping: ModalDamping) -> Dependence:
    """How it depends on the ratio and on E and rho.

    Modes that are counted stay the same where E and rho change a body without springs, and
    2 omega_j (M phi_j) (M phi_j)^T goes with the root of E rho.
    """
    material = {
        f"{path}.material.E": body.material.E,
        f"{path}.material.rho": float(body.material.rho or 0),
    }
    powers = {parameter.name: (1.0, 1.0) for parameter in modal_parameters(path, damping)}
    if damping.end is None and body.spring_stiffness() is None:
        return Coefficient.of(powers | {name: (value, 0.5) for name, value in material.items()})
    return _OfTheseModes(Coefficient.of(powers), material)


def _modes(path: str, body: Body, damping: ModalDamping) -> Modes:
    """Every mode of a body alone up to the last one that is damped, and a little beyond."""
    pencil = Pencil.of(body.stiffness(), body.mass())
    matrices = pencil.at()
    try:
        end = damping.end
        if end is None:
            end = _end(path, matrices, len(damping.ratios or ()))
        end *= 1 + _BEYOND
        count = count_below(matrices, (2 * np.pi * end) ** 2)
        if count > _MOST:
            allowed = f"damping of at most {_MOST} modes; Rayleigh damping for more"
            raise InputError(f"{path}.damping.modal", f"{count} modes up to {end:g} Hz", allowed)
        return solve_modes(pencil, end)
    except ConvergenceError as error:
        raise ConvergenceError(f"modes of {path} for its damping: {error}") from error
    finally:
        release(matrices)


def _rayleigh_ritz(body: Body, vectors: Floats) -> tuple[Floats, Floats]:
    """Frequencies (Hz) and modes, by rising frequency, in the space that some modes span.

    Of modes far from the shift they were searched about the space is known far better than each is.
    """
    mass, stiffness = body.mass(), body.stiffness()
    gram, form = (
        all_inner(vectors, image_of(each, vectors), mass.comm) for each in (mass, stiffness)
    )
    kappa, turn = eigh(form, gram)
    return np.sqrt(np.maximum(kappa, 0.0)) / (2 * np.pi), vectors @ turn


def _end(path: str, matrices: Matrices, wanted: int) -> float:
    """A frequency (Hz) up to which there are so many elastic modes, and one more if there is one.

    Eigenvalues that are found are some of those that there are: there may be more below the last
    one, not less.
    """
    if wanted > matrices.size:
        allowed = f"at most {matrices.size}: all modes of the body"
        raise InputError(f"{path}.damping.modal.ratios", f"{wanted} ratios", allowed)
    count = min(wanted + 1 + _RIGID_MOTIONS, matrices.size)
    factors = Shifted(matrices, _below(matrices))
    search = NearestSearch(matrices, factors, _TOLERANCE, _MOST_RESTARTS, StageTimer())
    kappa, _ = search.nearest(count)
    factors.free()
    return float(np.sqrt(np.sort(kappa.real)[count - 1])) / (2 * np.pi)


def _below(matrices: Matrices) -> float:
    """A shift (1/s^2) below all modes, near to the lowest."""
    stiffness, mass = matrices.stiffness.getDiagonal(), matrices.mass.getDiagonal()
    stiffness.pointwiseDivide(stiffness, mass)
    largest = float(stiffness.max()[1])
    destroy(stiffness, mass)
    return -_BELOW * largest


def _rigid_up_to(modes: Modes) -> Floats:
    """Frequencies (Hz) up to which motions are rigid for all that rounding leaves, shape (n,)."""
    return _RIGID * modes.growth_uncertainties / (2 * np.pi)


def _groups(frequencies: Floats, uncertainties: Floats) -> NDArray[np.int64]:
    """Number of the multiple eigenvalue that each of rising frequencies belongs to, shape (n,)."""
    reach = np.maximum(_SAME * frequencies, uncertainties)
    apart = np.diff(frequencies) > reach[1:] + reach[:-1]
    return np.concatenate([[0], np.cumsum(apart)])[: len(frequencies)]


def _factors(
    path: str, damping: ModalDamping, frequencies: Floats, groups: NDArray[np.int64]
) -> Floats:
    """Damping ratios of elastic modes relative to the parameter, shape (n,).

    Modes that share a frequency have the same. Any other vectors would do as well for them: C must
    not depend on which were found.
    """
    means = np.bincount(groups, frequencies) / np.bincount(groups)
    if damping.end is not None:
        return damping.factors_at(means)[groups]
    factors = damping.factors_at(frequencies)
    least, largest = np.full(len(means), np.inf), np.zeros(len(means))
    np.minimum.at(least, groups, factors)
    np.maximum.at(largest, groups, factors)
    split = np.flatnonzero(least != largest)
    if len(split):
        members = np.flatnonzero(groups == split[0]) + 1
        allowed = (
            f"the same ratio for elastic modes {members[0]} to {members[-1]}, which share the "
            f"frequency {means[split[0]]:.6g} Hz"
        )
        raise InputError(f"{path}.damping.modal.ratios", damping.ratios, allowed)
    return factors
