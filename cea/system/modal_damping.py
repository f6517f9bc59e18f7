"""Modal damping as pieces of a pencil: the modes of a body alone, and what damps them.

By the path of the body in a scene, ``bodies.<name>``, the parameter is ``.damping.modal.ratio``, or
``.damping.modal.ratios``, a factor on these.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Floats
from cea.body import Body
from cea.damping import ModalDamping
from cea.eigen.blocks import image_of
from cea.eigen.parameters import Coefficient, Dependence, Parameter
from cea.eigen.unformed import LowRank, LowRankTerm
from cea.errors import ConvergenceError, InputError
from cea.system.body_modes import ElasticModes, elastic_modes

_SAME = 1e-8
"""Relative distance up to which frequencies are those of one multiple eigenvalue."""
_MOST = 2000
"""Most modes of a body that are damped one by one."""


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


@dataclass(frozen=True)
class DampedModes:
    """Modes of a body that are damped.

    Parameters
    ----------
    vectors, images
        phi with phi^T M phi = 1, and M phi, the rows of this rank, shape (n_local, n).
    weights
        2 zeta omega (1/s) at a parameter of 1, shape (n,).
    """

    vectors: Floats
    images: Floats
    weights: Floats


def damped_modes(path: str, body: Body, damping: ModalDamping) -> DampedModes:
    """Modes of a body that modal damping damps; rigid motions are none of them.

    Parameters
    ----------
    path
        Path of the body in a scene.
    body
        The body.
    damping
        What damps it.

    Raises
    ------
    InputError
        When more ratios are given than the body has modes, modes of one frequency are given
        different ones, or modes are too many to be damped one by one.
    ConvergenceError
        When the modes of the body are not found.
    """
    counted = damping.ratios if damping.end is None and damping.ratios is not None else ()
    modes = _modes(path, body, damping, len(counted))
    if len(counted) > len(modes.frequencies):
        allowed = f"at most {len(modes.frequencies)}: all elastic modes of the body"
        raise InputError(f"{path}.damping.modal.ratios", f"{len(counted)} ratios", allowed)
    factors = _factors(path, damping, modes.frequencies, _groups(modes))
    damped = factors > 0
    vectors = modes.vectors[:, damped]
    weights = (4 * np.pi * factors * modes.frequencies)[damped]
    return DampedModes(vectors, image_of(body.mass(), vectors), weights)


def modal_term(
    path: str, body: Body, damping: ModalDamping, modes: DampedModes, first: int
) -> LowRankTerm:
    """Modal damping of a body, sum_j 2 zeta_j omega_j (M phi_j) (M phi_j)^T.

    Parameters
    ----------
    path, body, damping
        As for :func:`damped_modes`, whose result the modes are.
    modes
        The modes.
    first
        Number of its first row among the unknowns of this rank.
    """
    piece = LowRank(modes.images, modes.weights, first)
    return LowRankTerm(piece, modal_coefficient(path, body, damping))


def modal_parameters(path: str, damping: ModalDamping) -> Iterator[Parameter]:
    """The parameter of modal damping; path and damping as for :func:`damped_modes`."""
    if damping.ratio is not None:
        yield Parameter(f"{path}.damping.modal.ratio", damping.ratio)
    else:
        yield Parameter(f"{path}.damping.modal.ratios", 1.0, "a factor on the ratios")


def modal_coefficient(path: str, body: Body, damping: ModalDamping, *others: str) -> Dependence:
    """How it depends on the ratio, on E and rho, and on other parameters as they are.

    Modes that are counted stay the same where E and rho change a body without springs, and
    2 omega_j (M phi_j) (M phi_j)^T goes with the root of E rho.
    """
    material = {
        f"{path}.material.E": body.material.E,
        f"{path}.material.rho": float(body.material.rho or 0),
    }
    names = (*(parameter.name for parameter in modal_parameters(path, damping)), *others)
    powers = dict.fromkeys(names, (1.0, 1.0))
    if damping.end is None and body.spring_stiffness() is None:
        return Coefficient.of(powers | {name: (value, 0.5) for name, value in material.items()})
    return _OfTheseModes(Coefficient.of(powers), material)


def _modes(path: str, body: Body, damping: ModalDamping, counted: int) -> ElasticModes:
    """Elastic modes of a body up to the last one that is damped, and beyond."""
    try:
        return elastic_modes(body, damping.end, wanted=counted, most=_MOST)
    except InputError as error:
        allowed = f"{error.allowed} modes that are damped one by one; Rayleigh damping for more"
        raise InputError(f"{path}.damping.modal", error.value, allowed) from None
    except ConvergenceError as error:
        raise ConvergenceError(f"modes of {path} for its damping: {error}") from error


def _groups(modes: ElasticModes) -> NDArray[np.int64]:
    """Number of the multiple eigenvalue that each of the modes belongs to, shape (n,)."""
    reach = np.maximum(_SAME * modes.frequencies, modes.uncertainties)
    apart = np.diff(modes.frequencies) > reach[1:] + reach[:-1]
    return np.concatenate([[0], np.cumsum(apart)])[: len(reach)]


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
