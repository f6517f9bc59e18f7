"""Random pencils run and judged by dense eigenvalues.

None is missing where that was claimed, none made up or misjudged. Eigenvalues closer to each other
than their errors are one group, and groups are compared by their numbers: members of a multiple or
nearly defective eigenvalue have no names.
"""

import traceback
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.eigen.driver import solve_modes
from cea.errors import ConvergenceError, InputError

_SAFETY = 10.0
"""Factor on errors, which are estimates of first order."""


@dataclass
class Outcome:
    """What came of a pencil: faults, why it was refused, what was found."""

    name: str
    faults: list[str] = field(default_factory=list)
    refused: str | None = None
    modes: int = 0
    undecided: int = 0
    complete: bool = True


def outcome(problem):
    """Outcome of a random pencil; graded ones are judged by the one that was graded."""
    found = Outcome(problem.name)
    try:
        top, low = problem.max_frequency, problem.min_growth
        modes = solve_modes(problem.pencil(), top, min_growth=low)
    except (InputError, ConvergenceError) as error:
        found.refused = f"{type(error).__name__}: {error}"
    except Exception:
        found.faults = [f"crash: {traceback.format_exc()}"]
    else:
        found.modes, found.undecided = len(modes), modes.verdicts().count("undecided")
        found.complete = modes.window.complete
        judge = _faults_of_damped if modes.pencil.damped else _faults_of_undamped
        found.faults = judge(modes, problem)
    return found


def _faults_of_undamped(modes, problem):
    """Eigenvalues are compared by kappa = -lambda^2, which is real without friction."""
    kappa, error = problem.dense()
    error, found = _SAFETY * error, modes.eigenvalues
    top, own = 2 * np.pi * modes.window.max_frequency, _SAFETY * modes.growth_uncertainties
    z = np.append(-(found**2), kappa)
    reach = np.append(2 * np.abs(found) * own + own**2, error)
    reach = reach + 1e-8 * np.maximum(np.abs(z), 1e-3 * top**2)
    values, size = np.sqrt(-kappa.astype(complex)), np.sqrt(np.abs(kappa))
    values = np.where(values.imag < 0, -values, values) + 0j
    with np.errstate(divide="ignore", invalid="ignore"):
        margin = np.where(error < np.abs(kappa), error / (2 * size), np.sqrt(error))
    truth = _Truth(values, margin, -np.inf)
    if problem.friction is None and problem.scales is None:
        truth.grows &= kappa.real < -error  # what rounding makes of zero is no growth
        truth.may_grow = truth.grows
    return _faults(modes, modes.verdicts(), truth, _groups(z, reach, len(found)))


def _faults_of_damped(modes, problem):
    """Eigenvalues are compared by lambda, conjugates among them."""
    values, errors = problem.dense()
    window, found, own = modes.window, modes.eigenvalues, modes.growth_uncertainties
    top, twins = 2 * np.pi * window.max_frequency, found.imag > 0
    z = np.concatenate([found, found[twins].conj(), values])
    reach = _SAFETY * np.concatenate([own, own[twins], errors])
    reach = reach + 1e-9 * np.maximum(np.abs(z), 1e-2 * top)
    calls = np.array(modes.verdicts(), dtype=object)
    calls = np.append(calls, calls[twins])
    truth = _Truth(values, _SAFETY * errors, window.min_growth)
    return _faults(modes, calls, truth, _groups(z, reach, len(calls)))


class _Truth:
    """Eigenvalues lambda, their margins, and which of them grow."""

    def __init__(self, values, margin, min_growth):
        self.values, self.margin, self.min_growth = values, margin, min_growth
        limit = 1e-4 * np.abs(values)
        self.grows, self.may_grow = values.real > limit + margin, values.real > limit - margin


def _groups(z, reach, n):
    """Numbers of found values, the first n, and of dense ones within each other's errors."""
    near = np.abs(z[:, None] - z) <= reach[:, None] + reach
    count, label = connected_components(csr_array(near), directed=False)
    order = np.argsort(label, kind="stable")
    for members in np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1]):
        yield members[members < n], members[members >= n] - n


def _faults(modes, calls, truth, groups):
    window, verdict, calls = modes.window, modes.verdict(), np.array(calls, dtype=object)
    values, margin = truth.values, truth.margin
    top, frequency, growth = 2 * np.pi * window.max_frequency, np.abs(values.imag), values.real
    surely = (frequency < top - margin) & (growth > truth.min_growth + margin)
    surely &= np.abs(growth) < window.max_growth - margin
    if window.odd:  # it says itself that one of those without frequency is missing
        surely &= frequency > margin
    possibly = (frequency < top + margin) & (growth > truth.min_growth - margin)
    faults = []
    for ours, theirs in groups:
        place = f"{values[theirs][0]:.8g}" if len(theirs) else "a place where there is none"
        called = calls[ours]
        count = int(surely[theirs].sum())
        if len(ours) < count:
            faults.append(f"missing: {count} at {place}, {len(ours)} found")
        count = int(possibly[theirs].sum())
        if (called != "undecided").sum() > count:
            faults.append(f"spurious: {count} at {place}, {len(ours)} found")
        if len(theirs) and (called == "stable").sum() > (~truth.grows & possibly)[theirs].sum():
            faults.append(f"wrong-verdict: {place} is called stable and grows")
        if len(theirs) and (called == "unstable").sum() > truth.may_grow[theirs].sum():
            faults.append(f"wrong-verdict: {place} is called unstable and does not grow")
    if verdict == "stable" and (truth.grows & (frequency < top - margin)).any():
        faults.append("wrong-verdict: the window is called stable and a mode grows")
    if verdict == "unstable" and not (truth.may_grow & (frequency < top + margin)).any():
        faults.append("wrong-verdict: the window is called unstable and nothing grows")
    return faults
