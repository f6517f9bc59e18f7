"""Small scenes that are swept, and fresh solves beside what a sweep says of them."""

from pathlib import Path

import numpy as np
from reference_data import plane_meshes

from cea.eigen.matching import assign
from comparisons.sweep.points import read_fields
from comparisons.sweep.study import Asked, run
from scenes import assemble, load_scene

MU, P = "contacts.interface.mu", "contacts.interface.P"
MESHES = {
    "fe": {"upper": [8, 2], "lower": [5, 3]},
    "iga": {"upper": [10, 2], "lower": [7, 3]},
}


def sine_blocks(backend, *more, degree=2, finer=1, elements=None):
    """Changes of the blocks: friction that flutters at mu0 below one, meshes coarse or finer."""
    meshes = elements or MESHES[backend]
    meshes = {name: [finer * n for n in each] for name, each in meshes.items()}
    return (
        "contacts.interface.mu='sin(pi*x/2)'",
        *(f"bodies.{name}.backend='{backend}'" for name in meshes),
        *plane_meshes(backend, degree, meshes),
        *more,
    )


def driver_of_blocks(backend, p, **meshes):
    """Solver of the same at a contact stiffness."""
    changes = sine_blocks(backend, f"contacts.interface.p={p}", **meshes)
    return assemble(load_scene("blocks", changes)).driver


def sweep_of(scene, fields, out, overrides=(), **options):
    """A sweep along fields, whose store is gone."""
    swept = run(Asked(scene, read_fields(fields), tuple(overrides), **options), Path(out))
    if swept.store is not None:
        swept.store.discard()
    return swept


def eigenvalues(swept, i):
    """Lambda at a point of a sweep."""
    there = swept.spectra.there[i]
    return swept.spectra.growth[i][there] + 2j * np.pi * swept.spectra.frequency[i][there]


def assert_within_bounds(swept, i, modes):
    """Modes at a point are those of a full solve within bounds; pairs of their numbers."""
    found, spectra = eigenvalues(swept, i), swept.spectra
    rows, columns = assign(np.abs(found[:, None] - modes.eigenvalues))
    assert len(rows) == len(found)
    off = np.abs(found[rows] - modes.eigenvalues[columns])
    bounds = spectra.uncertainty[i][spectra.there[i]][rows]
    assert (off <= bounds + modes.growth_uncertainties[columns]).all()
    return rows, columns
