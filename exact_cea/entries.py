"""Entries of reference files: parameters and eigenvalues, written as text with all digits."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from flint import acb, arb, ctx
from numpy.typing import NDArray

from cea.files import write_whole
from exact_cea import galerkin_problems, lumped
from exact_cea.blocks import Blocks
from exact_cea.drum import Drum
from exact_cea.exceptional_points import exceptional_points
from exact_cea.galerkin import converged
from exact_cea.galerkin_problems import Ring
from exact_cea.solve import Spectrum, spectrum

Entry = dict[str, Any]

_DIGITS = 22


def drum(problem: Drum, max_frequency: float | None = None, count: int | None = None) -> Entry:
    """Return the entry of a drum, in plane strain if kz is None."""
    name: Entry = {"problem": "drum-2d" if problem.kz is None else "drum-3d", "m": problem.m}
    name |= _texts(problem, "kz") if problem.kz is not None else {}
    name |= _texts(problem, "p", "mu", "a", "b")
    name["radii"] = [*_texts(problem, "inner", "interface", "outer").values()]
    return name | _exact(_spectrum(problem, max_frequency, count))


def blocks_sine(
    problem: Blocks, max_frequency: float | None = None, count: int | None = None
) -> Entry:
    """Return the entry of blocks with friction ``mu0 sin(pi x / length)``."""
    kz = None if problem.kz is None else str(problem.kz)
    name = {"problem": "blocks-sine-mu", "kz": kz} | _texts(problem, "p", "mu0")
    return name | _sizes(problem) | _exact(_spectrum(problem, max_frequency, count))


def blocks_constant(
    problem: Blocks, max_frequency: float | None = None, count: int | None = None
) -> Entry:
    """Return the entry of blocks with constant friction mu0."""
    name: Entry = {"problem": "blocks-constant-mu"}
    if problem.kz is not None:
        name["kz"] = str(problem.kz)
    name |= {"p": str(problem.p), "mu": str(problem.mu0)} | _sizes(problem)
    return name | _approximate(
        *converged(
            lambda fine: galerkin_problems.blocks(problem, 14 if fine else 12, 4, constant=True),
            problem.scale(),
            count,
            max_frequency,
        )
    )


def ring(problem: Ring, max_frequency: float | None = None, count: int | None = None) -> Entry:
    """Return the entry of a ring."""
    name: Entry = {"problem": "ring-rollers", "m": problem.m}
    name |= _texts(problem, "p", "mu", "a", "b")
    name["sizes"] = [*_texts(problem, "inner", "outer", "height_a", "height_b").values()]
    return name | _approximate(
        *converged(
            lambda fine: galerkin_problems.ring(problem, 16 if fine else 14, 1),
            problem.scale(),
            count,
            max_frequency,
        )
    )


def thresholds(problem: Blocks, mu_max: float, max_frequency: float) -> list[Entry]:
    """Return an entry for each exceptional point of blocks with sinusoidal friction."""
    name = {"p": str(problem.p)} | ({} if problem.kz is None else {"kz": str(problem.kz)})
    return [
        {
            **name,
            "mu_c": _text(point.mu_c, point.digits),
            "lam2": _text(point.kappa, point.digits),
            "omega": _text(point.omega, point.digits),
            "digits": min(point.digits, _DIGITS),
            **_sizes(problem),
        }
        for point in exceptional_points(problem, mu_max, max_frequency)
    ]


def lumped_system(system: lumped.LumpedSystem, info: dict[str, str]) -> Entry:
    """Return the entry of a lumped system, with eigenvalues of both signs of Im."""
    return {
        "name": system.name,
        **{
            name: [[float(x) for x in row] for row in matrix]
            for name, matrix in (("M", system.M), ("C", system.C), ("K", system.K))
        },
        "lam": [_pair(value, _DIGITS) for value in lumped.eigenvalues(system)],
        "info": info,
    }


def write(entries: Sequence[Entry], file: Path) -> None:
    """Write entries atomically as a JSON list, one entry per line."""
    text = "[\n" + ",\n".join(json.dumps(entry) for entry in entries) + "\n]\n"
    write_whole(text.encode(), file)


def _spectrum(problem: Drum | Blocks, max_frequency: float | None, count: int | None) -> Spectrum:
    return spectrum(problem, max_frequency, count, guess=galerkin_problems.guess(problem))


def _sizes(problem: Blocks) -> Entry:
    sizes = _texts(problem, "height_a", "height_b", "length")
    return _texts(problem, "a", "b") | {"sizes": [*sizes.values()]}


def _texts(problem: Drum | Blocks | Ring, *names: str) -> Entry:
    """Return parameters as the user wrote them."""
    return {name: str(getattr(problem, name)) for name in names}


def _exact(found: Spectrum) -> Entry:
    entry: Entry = {
        "lam": [_pair(root.value, root.digits) for root in found.roots],
        "digits": min((root.digits for root in found.roots), default=_DIGITS),
        "window": {"max_frequency": found.box.top, "max_growth": found.box.right},
    }
    entry["digits"] = min(entry["digits"], _DIGITS)
    if found.contact_free:
        entry["lam_contact_free"] = [_pair(value, _DIGITS) for value in found.contact_free]
    return entry


def _approximate(values: NDArray[np.complex128], digits: list[int]) -> Entry:
    """Return eigenvalues in double precision; small real parts are not set to zero."""
    pairs = [[f"{value.real:.16g}", f"{value.imag:.16g}"] for value in values]
    return {"lam": pairs, "digits": min(digits, default=0), "digits_each": digits}


def _pair(value: acb, digits: int) -> list[str]:
    """Return real and imaginary part, rounded to the absolute accuracy of the modulus."""
    with ctx.workdps(3 * _DIGITS):
        size = float(abs(value).mid())
        return [_text(part, digits, size) for part in (value.real, value.imag)]


def _text(part: arb, digits: int, size: float | None = None) -> str:
    with ctx.workdps(3 * _DIGITS):
        if part.is_zero() or size == 0:
            return "0"
        lost = 0.0 if size is None else math.log10(size / max(abs(float(part)), 1e-300))
        held = min(_DIGITS, max(1, math.floor(digits - lost)))
        return str(part.mid().str(held, radius=False))
