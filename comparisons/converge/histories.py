"""What is known of a cluster of modes on every mesh, and of the window as a whole."""

from dataclasses import dataclass, replace
from math import log

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.eigenvalue_matching import assign
from comparisons.converge.bars import Usual, rate_of, typical_rate
from comparisons.converge.following import Cluster, Sequence
from comparisons.converge.parts import positions_of
from comparisons.converge.theory import reduction
from scenes.refinement import Resolution

_OF_DEGREE = log(10.0)
"""Most that a last step is trusted to have taken off where it raises the degree of Lagrange
elements, as a logarithm: where solutions are not quite smooth, as at edges of curved faces that
slide, elements of a degree more find little more in them, and no probe of a coarse mesh tells."""
_FITS = 1.5
"""Factor between two changes, over what was expected of them, up to which they are as expected."""


@dataclass(frozen=True)
class History:
    """Numbers of a cluster over the levels that have it.

    Parameters
    ----------
    values
        lambda (1/s), shape (levels, members).
    rounding
        Their errors by rounding on the newest level (1/s), shape (members,).
    residual
        Largest relative residual there.
    resolutions
        The meshes.
    positions
        Logarithms of what is expected to be taken off from the error of their mean.
    rigid
        Whether lambda is zero but for rounding on all of them.
    expected
        Relative errors of their mean on all levels, where errors are known in their parts.
    splittings
        The same of the squared splitting of a pair, relative to 4 m sqrt(s).
    of_splitting
        Positions of the splitting, where they are its own.
    """

    values: Complexes
    rounding: Floats
    residual: float
    resolutions: list[Resolution]
    positions: list[float]
    rigid: bool
    expected: Floats | None = None
    splittings: Floats | None = None
    of_splitting: list[float] | None = None

    def usual(self, window: "Window") -> Usual:
        """Last relative change of lambda, or of the mean, that is no luck."""
        return _usual(self.expected, window)

    def usual_splitting(self, window: "Window") -> Usual:
        """The same of the squared splitting, relative to 4 m sqrt(s)."""
        return _usual(self.expected if self.splittings is None else self.splittings, window)

    @property
    def splitting_positions(self) -> list[float]:
        """Logarithms of what is expected to be taken off from the error of the splitting."""
        return self.positions if self.of_splitting is None else self.of_splitting


@dataclass(frozen=True)
class Window:
    """What the modes of a window show together, beside which that of one may be luck.

    Parameters
    ----------
    rate
        Observed order over that of theory; None where it is not known.
    change
        Last difference of lambda, relative; 0 where it is not known.
    over
        The same over what is expected from the parts of the errors: of the last two differences
        the larger, as a step that leaves most of an error changes little.
    """

    rate: float | None = None
    change: float = 0.0
    over: float = 1.0


def _usual(expected: Floats | None, window: Window) -> Usual:
    if expected is None:
        return Usual(window.change, unmeasured=True)
    if len(expected) < 2:
        return Usual(0.0, own=True)
    change = window.over * float(expected[-2] - expected[-1])
    return Usual(change, own=True, left=window.over * float(expected[-1]))


def history_of(cluster: Cluster, sequence: Sequence) -> History:
    """The members on all levels, each beside the one of the newest that is nearest."""
    newest = sequence.last.eigenvalues[cluster.newest]
    rows, rounding, resolutions = [], np.zeros(len(newest)), []
    residual, rigid = 0.0, True
    for numbers, level in zip(cluster.members, sequence.levels, strict=True):
        if numbers is None:
            continue
        ordered = _nearest(level.eigenvalues[numbers], newest)
        rows.append(level.eigenvalues[numbers][ordered])
        rounding = level.uncertainties[numbers][ordered]
        residual = float(level.residuals[numbers].max())
        rigid &= bool(level.rigid[numbers].all())
        resolutions.append(level.resolution)
    values = np.array(rows)
    rigid &= len(values) > 1
    if sequence.parts is None or rigid:
        positions = _positions(values, resolutions, sequence)
        return History(values, rounding, residual, resolutions, positions, rigid)
    parts, modes = sequence.parts, cluster.members[sequence.parts.level]
    own = parts.of_mean(modes)
    fallen = parts.fallen(own, parts.local(own, modes), resolutions)
    raised = _raised(resolutions, sequence)
    history = History(
        values,
        rounding,
        residual,
        resolutions,
        _trusted(positions_of(fallen, own), raised=raised),
        rigid,
        expected=fallen.sum(axis=1),
    )
    if modes is None or len(modes) != 2 or parts.damped:
        return history
    squares = parts.eigenvalues[modes] ** 2
    splitting = abs(0.25 * (squares[0] - squares[1]) ** 2)
    unit = max(4 * abs(squares.mean()) * np.sqrt(splitting), np.finfo(float).tiny)
    own = parts.of_splitting(modes) / unit
    fallen = parts.fallen(own, parts.local(own, modes), resolutions)
    sizes = np.abs(fallen)
    squared = values**2
    changes = np.diff(0.25 * (squared[:, 0] - squared[:, 1]) ** 2).real
    kept = fallen if _fit(fallen.sum(axis=1), changes) else sizes
    positions = _trusted(positions_of(kept, own), raised=raised)
    return replace(history, splittings=sizes.sum(axis=1), of_splitting=positions)


def _fit(left: Floats, changes: Floats) -> bool:
    """Whether a number changed as is expected where its parts take off from one another.

    Parameters
    ----------
    left
        What it was expected to change yet on each mesh, up to a factor, shape (meshes,).
    changes
        What it changed from mesh to mesh, shape (meshes - 1,).
    """
    if len(changes) < 2 or not (np.abs(left[1:]) < np.abs(left[:-1])).all():
        return False
    if not ((left[1:] * left[:-1]) > 0).all():
        return False
    ratios = changes[-2:] / -np.diff(left)[-2:]
    return bool((ratios > 0).all() and ratios.max() <= _FITS * ratios.min())


def _raised(resolutions: list[Resolution], sequence: Sequence) -> bool:
    """Whether the last step raises the degree of Lagrange elements in a body."""
    if sequence.backend != "fe" or len(resolutions) < 2:
        return False
    old, new = (dict(each.bodies) for each in resolutions[-2:])
    return any(old[name].degree < new[name].degree for name in new)


def _trusted(positions: list[float], *, raised: bool) -> list[float]:
    """Positions of which the last step takes off no more than it is trusted with."""
    if not raised:
        return positions
    return [*positions[:-1], min(positions[-1], positions[-2] + _OF_DEGREE)]


def _positions(values: Complexes, resolutions: list[Resolution], sequence: Sequence) -> list[float]:
    """Logarithms of what theory takes off, from what each step changed in the mean of lambda^2."""
    means = (values**2).mean(axis=1)
    sizes = np.maximum(np.abs(means), np.finfo(float).tiny)
    changes = 0.5 * np.abs(np.diff(means)) / sizes[1:]
    positions = [0.0]
    for old, new, change in zip(resolutions, resolutions[1:], changes, strict=False):
        taken = reduction(old, new, float(change), singular=sequence.singular)
        positions.append(positions[-1] + taken)
    return positions


def _nearest(values: Complexes, wanted: Complexes) -> Ints:
    """Order in which some numbers are nearest to others."""
    return assign(np.abs(values[None, :] - wanted[:, None]))[1]


def window_of(found: list[Cluster], sequence: Sequence, *, damped: bool) -> Window:
    """Medians over the clusters of a level."""
    rates, changes = [], []
    last: list[float] = []
    former: list[float] = []
    for cluster in found:
        history = history_of(cluster, sequence)
        if history.rigid:
            continue
        numbers = (history.values if damped else history.values**2).mean(axis=1)
        rates.append(rate_of(numbers.tolist(), history.positions))
        if len(numbers) > 1 and numbers[-1] != 0:
            change = float(abs(numbers[-1] - numbers[-2]) / abs(numbers[-1]))
            changes.append(change if damped else 0.5 * change)
            if history.expected is not None:
                over = _over(numbers, history.expected, damped=damped)
                last += over[-1:]
                former += over[-2:-1]
    return Window(
        typical_rate(rates),
        float(np.median(changes)) if changes else 0.0,
        max((float(np.median(each)) for each in (last, former) if each), default=1.0),
    )


def _over(numbers: Complexes, expected: Floats, *, damped: bool) -> list[float]:
    """Relative changes of a number over what was expected of them."""
    sizes = np.abs(np.diff(numbers)) / abs(numbers[-1])
    taken = np.maximum(-np.diff(expected), np.finfo(float).tiny)
    return ((sizes if damped else 0.5 * sizes) / taken).tolist()
