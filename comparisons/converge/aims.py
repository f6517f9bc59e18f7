"""What the next mesh is to reach, mode by mode, where errors are known in their parts."""

from math import inf, log, tau

import numpy as np

from cea.arrays import Complexes, Floats
from cea.eigen.classify import GROWING, thresholds
from comparisons.converge.bars import SAFETY
from comparisons.converge.following import Sequence
from comparisons.converge.judged import Judged, frequency_shortfall, shortfall
from comparisons.converge.leanest import Wanted
from comparisons.converge.parts import Parts, taken_off
from comparisons.converge.quantities import Member
from comparisons.converge.request import Request
from comparisons.converge.steps import LEAST_GAIN, RESERVE
from scenes.read import Scene
from scenes.spec.analysis import ComplexEigenvalueAnalysis

_AMPLE = log(5.0)
"""What the error of a mode may be below the one allowed, as a logarithm, from which on it need not
fall: elements for modes that are right already are paid by all others."""
_REMAINS = 0.1
"""Part of an allowed error that solves in a richer space may leave."""
ENOUGH = 3
"""Numbers of a sequence from which on bars rest on an observed order."""


def is_asked(member: Member, request: Request, scene: Scene) -> bool:
    """Whether digits are asked of a mode."""
    analysis = scene.analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    if member.value.imag > tau * analysis.max_frequency:
        return False
    return not (request.unstable and member.verdict in ("stable", "rigid"))


def need_of(member: Member, request: Request, scene: Scene) -> float:
    """Factor by which the bar of a mode is too large; 1 or less where its digits are held."""
    analysis = scene.analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    return shortfall(member, request, analysis.growth_threshold)


def may_remain(eigenvalues: Complexes, request: Request, scene: Scene) -> Floats:
    """What solves may leave of errors of lambda (1/s), shape (n,): a tenth of what is allowed."""
    speeds = np.abs(eigenvalues)
    allowed = request.tolerance * speeds
    grows = eigenvalues.real != 0
    scale = _scale_of_growth(eigenvalues, scene)
    growth = np.where(grows, request.growth_tolerance * scale, np.inf)
    return np.asarray(_REMAINS * np.minimum(allowed, growth))


def wanted(
    judged: Judged,
    sequence: Sequence,
    request: Request,
    scene: Scene,
    rate: float,
    *,
    spare: float,
    most: float = inf,
    everywhere: bool = False,
) -> Wanted | None:
    """What is to be taken off from the errors of the modes.

    Of the mean of a pair, and of its splitting, which is its growth or what parts its frequencies.
    While bars rest on one mesh or two, what they would be is expected from the parts.

    Parameters
    ----------
    judged
        The newest modes, of the corrected mesh where there is one.
    sequence
        Levels with the parts of their errors.
    request, scene
        What is asked of which scene.
    rate
        Observed order over that of theory.
    spare
        Logarithm of what needs not be taken off, and is left to a correction.
    most
        Logarithm of what is to be taken off at most.
    everywhere
        Whether every part is to fall by half from the newest mesh, however small it is: one that
        was taken for small and is not is seen then. A correction of that mesh is no mesh.

    Returns
    -------
    Wanted or None
        None where no digits are asked of any mode.
    """
    parts, whole = sequence.parts, sequence.with_correction
    assert parts is not None
    asked = [
        (i, member, judged.cluster_of(i).members[parts.level])
        for i, member in enumerate(judged.members)
        if is_asked(member, request, scene) and not member.rigid
    ]
    if not asked:
        return None
    reached = whole.last.resolution
    errors = np.array([parts.of_mean(modes) for _, _, modes in asked])
    local = np.array([parts.local(e, m) for e, (_, _, m) in zip(errors, asked, strict=True)])
    now = parts.at(reached, errors, local).sum(axis=1)
    needs = np.array([need_of(member, request, scene) for _, member, _ in asked])
    few = len(whole.levels) < ENOUGH
    found = [_of_splitting(i, judged, parts, request, scene) for i, _, _ in asked]
    if few:
        speeds = np.array([abs(member.value) for _, member, _ in asked])
        bars = np.array([member.frequency_bar for _, member, _ in asked]) / speeds
        expected = SAFETY * now
        known = np.isfinite(bars)
        with np.errstate(invalid="ignore"):
            scaled = needs * np.minimum(1.0, expected / bars)
        of_means = np.where(known, scaled, expected / request.tolerance)
    else:
        alone = np.array([frequency_shortfall(member, request) for _, member, _ in asked])
        of_means = np.where([row is None for row in found], needs, alone)
    gains = np.log(np.maximum(of_means, 1e-3)) + RESERVE
    least = np.clip(gains + _AMPLE, 0.0, LEAST_GAIN)
    rows = [(*row, need) for row, need in zip(found, needs, strict=True) if row is not None]
    short = np.empty(0)
    if rows:
        ours, resolved, allowed, seen = (np.array(each) for each in zip(*rows, strict=True))
        now = parts.at(reached, ours, resolved).sum(axis=1)
        short = np.log(np.maximum(SAFETY * now / allowed if few else seen, 1e-3)) + RESERVE
        errors, local = np.concatenate([errors, ours]), np.concatenate([local, resolved])
    if max(least.max(), short.max(initial=0.0)) < LEAST_GAIN:  # all are right: one more shows that
        least[:] = LEAST_GAIN
    gains = np.clip(gains - spare, least, most)
    gains = np.concatenate([gains, np.clip(short - spare, 0.0, most)])
    if everywhere:
        usual = errors.max(axis=0)
        alone, resolved = np.diag(usual)[usual > 0], np.diag(local.max(axis=0))[usual > 0]
        there = [parts.at(at, alone, resolved) for at in (sequence.last.resolution, reached)]
        halved = LEAST_GAIN - taken_off(there[0], there[1], alone)
        errors, local = np.concatenate([errors, alone]), np.concatenate([local, resolved])
        gains = np.concatenate([gains, rate * halved])
    return Wanted(errors, local, gains, reached, rate)


def _of_splitting(
    mode: int, judged: Judged, parts: Parts, request: Request, scene: Scene
) -> tuple[Floats, Floats, float] | None:
    """What digits ask of the splitting of the pair that a mode is of; None where nothing.

    With lambda^2 = m +- sqrt(s) growth is sqrt(-s) / (2 omega) while it is small beside omega. A
    pair that is none on the mesh where parts were measured has of its splitting what is usual.

    Returns
    -------
    tuple
        Parts of the error, relative to growth or to abs(lambda), shape (parts,); the same as
        :meth:`Parts.local` has them; the error that is allowed.
    """
    member, cluster = judged.members[mode], judged.cluster_of(mode)
    modes = cluster.members[parts.level]
    known = modes is not None and len(modes) == 2
    omega, growth = abs(member.value.imag), abs(member.value.real)
    if parts.damped:
        return None
    if member.verdict in GROWING or (member.value.real > 0 and not known):
        scale = _scale_of_growth(np.array(member.value), scene)
        if modes is None or not known:
            modes, of_lambda = None, parts.of_mean(None)
        else:
            of_lambda = np.abs(parts.of_splitting(modes)) / (8 * omega**3 * growth)
        own = of_lambda * omega / scale
        return own, parts.local(of_lambda, modes), request.growth_tolerance
    decides = np.isfinite(member.frequency_bar) and mode == cluster.newest[0]
    if modes is None or not known or len(cluster.newest) != 2 or not decides or growth != 0:
        return None
    squares = [judged.members[each].value ** 2 for each in cluster.newest]
    apart = 0.5 * abs(squares[0] - squares[1])
    may = 2 * omega**2 * request.tolerance  # as bars have the error of sqrt(s) from that of s
    of_square = may * (2 * apart - may) if may < apart else max(apart**2, may**2 - apart**2)
    unit = 4 * omega**2 * max(apart, may)
    of_lambda = np.abs(parts.of_splitting(modes)) / unit
    return of_lambda, parts.local(of_lambda, modes), of_square / unit


def _scale_of_growth(eigenvalues: Complexes, scene: Scene) -> Floats:
    """Growth rates (1/s) that digits of growth are relative to, of the shape of the eigenvalues."""
    analysis = scene.analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    slow = thresholds(np.atleast_1d(eigenvalues), analysis.growth_threshold)
    return np.maximum(np.abs(eigenvalues.real), slow.reshape(np.shape(eigenvalues)))
