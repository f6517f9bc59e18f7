"""Exact eigenvalues of whole scenes, and scenes run on given meshes."""

import json
from functools import cache
from pathlib import Path

import numpy as np

from comparisons.study.matching import match_spectrum
from exact_cea.reference import whole_spectrum
from scenes import run_scene
from scenes.spec.reading import load_scene

DATA = Path(__file__).parents[1] / "data"
DRUM_BODIES = ("outer", "inner")
BLOCK_BODIES = ("upper", "lower")


@cache
def stored(name):
    """Entries of a file of reference eigenvalues."""
    return json.loads((DATA / f"{name}.json").read_text())


COALESCENCES = [
    (float(entry["p"]), float(entry["mu_c"]), float(entry["omega"]))
    for entry in stored("blocks_sine_mu_thresholds")
]
"""p, mu and Im lambda at which modes of the blocks with friction mu sin(pi x / 2) coalesce."""


def eigenvalues(entry):
    """Lambda of an entry."""
    return np.array([complex(float(re), float(im)) for re, im in entry["lam"]])


def both_signs(values, m):
    """Eigenvalues of the orders m and -m."""
    return values if m == 0 else np.concatenate([values, -values.conj()])


def whole_ring(mu="0.3"):
    """Elastic eigenvalues of the ring; orders above 8 begin beyond 1.1e5 rad/s."""
    parts = [
        both_signs(eigenvalues(entry), entry["m"])
        for entry in stored("ring_rollers")
        if entry["mu"] == mu
    ]
    values = np.concatenate(parts)
    return values[values.imag > 1]


def exact(scene, highest, p=1, mu="0.3"):
    """Eigenvalues of a plane scene, some beyond the highest that will be compared."""
    if scene == "blocks_constant_mu":
        return next(
            eigenvalues(entry)
            for entry in stored("blocks_constant_mu")
            if (float(entry["p"]), entry["mu"]) == (p, mu)
        )
    return whole_spectrum(scene, max_frequency=1.05 * highest, p=p, mu=mu).values


def plane_meshes(backend, degree, elements, **options):
    """Overrides that give bodies so many elements, e.g. outer=[4, 32]."""
    overrides = []
    for body, numbers in elements.items():
        if backend == "fe":
            cell = {"cell": "quadrilateral", "degree": degree, "elements": numbers} | options
            mesh = ", ".join(f"{name} = {json.dumps(value)}" for name, value in cell.items())
        else:
            mesh = f"degree = [{degree}, {degree}], elements = {numbers}"
        overrides.append(f"bodies.{body}.mesh.{backend}={{{mesh}}}")
    return overrides


def solve(scene, highest, overrides=(), backend=None):
    """Modes of a scene up to somewhat more than a highest Im lambda."""
    window = f"analysis.max_frequency={1.03 * highest / (2 * np.pi)}"
    return run_scene(load_scene(Path(scene), [*overrides, window], backend)).modes


def compare(modes, values, highest):
    """Computed modes against exact eigenvalues, elastic ones up to a highest Im lambda."""
    return match_spectrum(modes.eigenvalues, values, (1e-3 * highest, highest))
