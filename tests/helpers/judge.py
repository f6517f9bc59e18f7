"""Modes judged by dense eigenvalues: none missing where it was claimed, none made up or misjudged.

Eigenvalues closer to each other than their errors are one group, and groups are compared by their
numbers: members of a multiple or nearly defective eigenvalue have no names.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from dense_reference import Dense, lambda_error, lambda_of
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from cea.eigen.spectrum import Spectrum

_SAFETY = 10.0
"""Factor on errors, which are estimates of first order."""
_SAME = 1e-8
"""Part of kappa by which values may differ whatever their errors."""
_ZERO = 1e-9
"""Part of the top of the window below which kappa counts as zero."""


@dataclass(frozen=True)
class Fault:
    """What is wrong with a result: ``missing``, ``spurious``, ``inaccurate``, ``wrong-verdict``."""

    kind: str
    text: str


@dataclass(frozen=True)
class Found:
    """What a result says: values, their errors, its verdicts, what it claims to have searched.

    Parameters
    ----------
    kappa, error
        Values -lambda^2 and their errors by residual and condition, shape (n,).
    verdicts
        "stable", "unstable" or "undecided" of each.
    verdict
        The same of the whole window.
    complete
        Whether it claims that every mode of the window was found.
    top
        Largest Im lambda of the window.
    claims
        Whether kappas with errors lie surely inside what was searched completely, and whether they
        possibly lie in the window: a function of both.
    """

    kappa: np.ndarray
    error: np.ndarray
    verdicts: np.ndarray
    verdict: str
    complete: bool
    top: float
    claims: object


def found_by(spectrum: Spectrum, threshold: float | None) -> Found:
    """What a result says of itself."""
    window, values = spectrum.window, spectrum.eigenvalues
    top = 2 * np.pi * window.max_frequency
    error = _SAFETY * spectrum.growth_uncertainties

    def claims(kappa, error):
        lambdas, margin = lambda_of(kappa), lambda_error(kappa, error)
        frequency, growth = lambdas.imag, np.abs(lambdas.real)
        surely = (frequency < top - margin) & (growth < window.max_growth - margin)
        if window.odd:  # it says itself that one of those without frequency is missing
            surely &= frequency > margin
        return surely, frequency < top + margin

    return Found(
        kappa=-(values**2),
        error=2 * np.abs(values) * error + error**2,
        verdicts=np.array(spectrum.verdicts(threshold), dtype=object),
        verdict=spectrum.verdict(threshold),
        complete=window.complete,
        top=top,
        claims=claims,
    )


def judge(found: Found, dense: Dense, threshold: float | None) -> list[Fault]:
    """Faults of a result.

    Parameters
    ----------
    found
        What it says.
    dense
        All eigenvalues there are.
    threshold
        Growth rate above which modes are unstable (1/s); None is relative to lambda.
    """

    def limit(values):
        if threshold is not None:
            return np.full(len(values), threshold)
        return 1e-4 * np.abs(values)

    faults = []
    for ours, theirs in _groups(found, dense):
        faults += _group_faults(found, dense, ours, theirs, limit)
    faults = _pairs_made_one(faults)
    faults += _window_faults(found, dense, limit)
    return faults


def left_out(found: Found, dense: Dense) -> int:
    """Number of eigenvalues in the window, whatever their growth, that were not found."""
    inside = dense.eigenvalues.imag < found.top - _SAFETY * dense.lambda_error
    return sum(
        max(int(inside[theirs].sum()) - len(ours), 0) for ours, theirs in _groups(found, dense)
    )


def _groups(found: Found, dense: Dense) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Numbers of found and of dense values that lie within each other's errors."""
    top = found.top**2
    values = np.concatenate([found.kappa, dense.kappa])
    error = np.concatenate([found.error, _SAFETY * dense.error])
    slack = _SAME * np.maximum(np.abs(values), 1e-2 * _ZERO / _SAME * top)
    reach = error + slack
    near = np.abs(values[:, None] - values[None, :]) <= reach[:, None] + reach[None, :]
    count, label = connected_components(csr_array(near), directed=False)
    n = len(found.kappa)
    order = np.argsort(label, kind="stable")
    for members in np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1]):
        yield members[members < n], members[members >= n] - n


def _growth(dense: Dense, limit) -> tuple[np.ndarray, np.ndarray]:
    """Which dense eigenvalues surely grow faster than the threshold, and which possibly do."""
    values, margin = dense.eigenvalues, _SAFETY * dense.lambda_error
    above = limit(values)
    surely = values.real > above + margin
    if dense.symmetric:  # kappa are real: what rounding makes of zero is no growth
        surely &= dense.kappa.real < -_SAFETY * dense.error
        return surely, surely
    return surely, values.real > above - margin


def _group_faults(found, dense, ours, theirs, limit) -> Iterator[Fault]:
    kappa = dense.kappa[theirs]
    surely, possibly = found.claims(kappa, _SAFETY * dense.error[theirs])
    where = _told(found.kappa[ours] if len(ours) else kappa)
    if len(ours) < surely.sum():
        yield Fault("missing", f"{int(surely.sum())} at lambda = {where}, {len(ours)} found")
    sure = found.verdicts[ours] != "undecided"
    if sure.sum() > possibly.sum():
        yield Fault("spurious", f"{int(possibly.sum())} at lambda = {where}, {len(ours)} found")
    grows, may_grow = (each[theirs] for each in _growth(dense, limit))
    called = found.verdicts[ours]
    stable = int((called == "stable").sum())
    if len(theirs) and stable > int((~grows & possibly).sum()):
        yield Fault("wrong-verdict", f"lambda = {where} is called stable and grows")
    if len(theirs) and int((called == "unstable").sum()) > int(may_grow.sum()):
        yield Fault("wrong-verdict", f"lambda = {where} is called unstable and does not grow")


def _pairs_made_one(faults: list[Fault]) -> list[Fault]:
    """A value missing here and made up nearby is one, inaccurate."""
    missing = [f for f in faults if f.kind == "missing"]
    for lost in missing:
        for other in faults:
            if other.kind == "spurious" and _close(lost.text, other.text):
                faults = [f for f in faults if f is not lost and f is not other]
                faults.append(Fault("inaccurate", f"{lost.text}; {other.text}"))
                break
    return faults


def _close(one: str, other: str) -> bool:
    a, b = (complex(t.split("lambda = ")[1].split(" ")[0].rstrip(",")) for t in (one, other))
    return abs(a - b) <= 1e-2 * abs(a)


def _window_faults(found: Found, dense: Dense, limit) -> Iterator[Fault]:
    margin = _SAFETY * dense.lambda_error
    grows, may_grow = _growth(dense, limit)
    values = dense.eigenvalues
    inside, near = values.imag < found.top - margin, values.imag < found.top + margin
    if found.verdict == "stable" and (grows & inside).any():
        worst = dense.kappa[grows & inside]
        fastest = worst[np.argmax(lambda_of(worst).real)]
        text = f"the window is called stable; lambda = {_told([fastest])} grows"
        yield Fault("wrong-verdict", text)
    if found.verdict == "unstable" and not (may_grow & near).any():
        yield Fault("wrong-verdict", "the window is called unstable and nothing in it grows")


def _told(kappa) -> str:
    return f"{complex(lambda_of(np.asarray(kappa))[0]):.6g}"
