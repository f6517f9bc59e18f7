"""The error of every mode as a sum of parts, one for each body and direction and for its edges.

What each part is comes from measurement on one mesh (:mod:`comparisons.converge.probes`); how it
falls from theory (:mod:`comparisons.converge.theory`). A part of smooth solutions falls with the
elements along its direction and the degree of its body, that of singular edges with the elements
across them and their layers. Bodies and directions so are refined by what they owe, and the errors
of two meshes are compared that are finer in different directions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats, Ints
from comparisons.converge.theory import LARGEST_ERROR, SMALLEST_ERROR
from meshes.edge_layers import RATIO
from scenes.refinement import BodyResolution, Resolution

EDGES = 0.6
"""Exponent of displacements at edges, the least that usual nu have at clamped ones; splines of a
higher degree, as smooth as they can be, have no more functions there and do little better."""
RE_ENTRANT = 0.5445
"""The same at re-entrant edges of a right angle (Williams 1952)."""
_SMOOTH = 0.1
"""Part of what was measured along a direction that is no doing of edges, at least."""
_MATTERS = 0.05
"""Share of an error as measured from which on a part matters."""
_LEADS = log(5.0)
"""What a step is trusted to take off beyond that of the part that falls least, as a logarithm."""
_LEAST_STEP = 0.1
"""What a finer mesh takes off at least: parts that are rounding do not tell."""


@dataclass(frozen=True)
class Part:
    """What a part of the errors comes from.

    Parameters
    ----------
    body
        Name of the body.
    directions
        Numbers of the directions along which finer elements make it fall: one; all of an
        unstructured mesh; those across which singular edges lie.
    edges
        Whether it is that of singular edges.
    of_degree
        What a degree more does for these over what as many more elements do: Lagrange elements
        with a corner at the edge gain twice as much, splines as smooth as they can be no more.
    exponent
        Of displacements at these, the least.
    """

    body: str
    directions: tuple[int, ...]
    edges: bool = False
    of_degree: float = 1.0
    exponent: float = EDGES


@dataclass(frozen=True)
class Parts:
    """What the modes of one mesh owe to each part.

    Parameters
    ----------
    parts
        What the parts come from.
    takes
        What theory says that each richer space takes off of its part, shape (parts,).
    eigenvalues
        lambda on the mesh (1/s), shape (modes,).
    corrected
        lambda in each richer space, shape (parts, modes).
    strained
        Strain energy of the body of each part over abs(lambda)^2 of the mode, of x^H M x = 1,
        shape (parts, modes).
    known
        Modes whose errors tell anything: not those of rigid motions, shape (modes,).
    damped
        Whether lambda itself is followed, not its square.
    resolution
        The mesh, densities of all bodies given.
    level
        Its number in the sequence.
    """

    parts: tuple[Part, ...]
    takes: Floats
    eigenvalues: Complexes
    corrected: Complexes
    strained: Floats
    known: NDArray[np.bool_]
    damped: bool
    resolution: Resolution
    level: int

    def of_mean(self, modes: Ints | None) -> Floats:
        """Parts of the relative error of lambda, or of the mean of some, shape (parts,).

        Parameters
        ----------
        modes
            Modes of the mesh that are judged together; None takes what is usual in the window.
        """
        if modes is None:
            every = [self.of_mean(np.array([i])) for i in np.flatnonzero(self.known)]
            return np.asarray(np.median(every, axis=0)) if every else np.zeros(len(self.parts))
        power = 1 if self.damped else 2
        mean = (self.eigenvalues[modes] ** power).mean()
        change = (self.corrected[:, modes] ** power).mean(axis=1) - mean
        size = max(abs(mean), np.finfo(float).tiny)
        return self._parted(np.abs(change) / (power * size * self.takes))

    def of_splitting(self, modes: Ints) -> Floats:
        """Parts of the error of the squared splitting of the lambda^2 of a pair, (parts,).

        They are what each will still change, with its sign: they may take off from one another.
        """
        change = _splitting(self.corrected[:, modes]) - _splitting(self.eigenvalues[None, modes])
        return np.copysign(self._parted(np.abs(change) / self.takes), change)

    def local(self, errors: Floats, modes: Ints | None) -> Floats:
        """Parts of a relative error of lambda over what the bodies take part, shape (parts,).

        Where a body takes little part in a mode its part of the error is small however crudely it
        is resolved; how well it is, and so what a degree more does, its share tells.

        Parameters
        ----------
        errors
            The parts.
        modes
            Modes of the mesh that are judged together; None takes what is usual in the window.
        """
        if modes is None:
            shares = np.median(self.strained[:, self.known], axis=1)
        else:
            shares = self.strained[:, modes].mean(axis=1)
        sizes = np.abs(errors)
        return sizes / np.maximum(shares, sizes / LARGEST_ERROR + np.finfo(float).tiny)

    def _parted(self, errors: Floats) -> Floats:
        """Parts of smooth solutions without what finer elements took off of that of edges."""
        found = errors.copy()
        for i, part in enumerate(self.parts):
            if not part.edges:
                continue
            across = [
                j
                for j, other in enumerate(self.parts)
                if other.body == part.body
                and not other.edges
                and other.directions[0] in part.directions
            ]
            both = float(errors[across].sum())
            if both > 0:
                halved = 1 - 2.0 ** (-2 * part.exponent)  # what elements of half the size take off
                found[across] *= max(1 - halved * float(errors[i]) / both, _SMOOTH)
        return found

    def at(self, resolution: Resolution, errors: Floats, local: Floats) -> Floats:
        """Parts of errors on another mesh, shape (n, parts).

        Parameters
        ----------
        resolution
            The mesh, densities of all bodies given.
        errors, local
            Parts on the mesh on which they were measured, and as :meth:`local` has them, shape
            (n, parts).
        """
        old, new = dict(self.resolution.bodies), dict(resolution.bodies)
        columns = [
            errors[:, i] * _left(local[:, i], part, old[part.body], new[part.body])
            for i, part in enumerate(self.parts)
        ]
        return np.stack(columns, axis=1)

    def fallen(self, errors: Floats, local: Floats, resolutions: Sequence[Resolution]) -> Floats:
        """Parts of one error on each of some meshes, shape (meshes, parts)."""
        return np.concatenate([self.at(each, errors[None], local[None]) for each in resolutions])


def taken_off(old: Floats, new: Floats, measured: Floats) -> Floats:
    """Logarithms of what a step is trusted to take off from errors in their parts, shape (n,).

    Little more than from the part that falls least, of those that matter: which of them leads on
    another mesh, of another degree most of all, is known less well than how each falls.

    Parameters
    ----------
    old, new
        Parts before and after the step, shape (n, parts).
    measured
        Parts as they were measured, shape (n, parts).
    """
    before, after, sizes = np.abs(old), np.abs(new), np.abs(measured)
    of_sums = _log_ratio(np.abs(old.sum(axis=1)), np.abs(new.sum(axis=1)))
    each = _log_ratio(before, after)
    matters = sizes >= _MATTERS * sizes.sum(axis=1, keepdims=True)
    least = np.where(matters, each, np.inf).min(axis=1)
    return np.asarray(np.minimum(of_sums, least + _LEADS))


def positions_of(fallen: Floats, measured: Floats) -> list[float]:
    """Logarithms, rising, of what is taken off from an error from mesh to mesh.

    Parameters
    ----------
    fallen
        Its parts on the meshes, shape (meshes, parts).
    measured
        Its parts as they were measured, shape (parts,).
    """
    steps = taken_off(fallen[:-1], fallen[1:], np.tile(measured, (len(fallen) - 1, 1)))
    return [0.0, *np.cumsum(np.maximum(steps, _LEAST_STEP)).tolist()]


def _log_ratio(old: Floats, new: Floats) -> Floats:
    tiny = np.finfo(float).tiny
    return np.asarray(np.log(np.maximum(old, tiny) / np.maximum(new, tiny)))


def _splitting(values: Complexes) -> Floats:
    """Squared splittings of pairs, shape (n,)."""
    squares = values**2
    return np.asarray((0.25 * (squares[:, 0] - squares[:, 1]) ** 2).real)


def _left(local: Floats, part: Part, old: BodyResolution, new: BodyResolution) -> Floats:
    """What is left of a part of all modes on a finer, or a coarser, mesh of its body."""
    each = [log(new.densities[d] / old.densities[d]) for d in part.directions]
    more = min(each)
    if part.edges:
        taken = more - (new.layers - old.layers) * log(RATIO)
        taken += part.of_degree * log(new.degree / old.degree)
        return np.full(len(local), np.exp(-2 * part.exponent * taken))
    before = np.log(np.clip(local, SMALLEST_ERROR, LARGEST_ERROR))
    after = (before - 2 * old.degree * more) * new.degree / old.degree
    return np.asarray(np.exp(after - before))
