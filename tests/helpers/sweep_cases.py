"""Small scenes that are swept, and fresh solves beside what a sweep says of them."""

from functools import cache
from pathlib import Path
from tempfile import gettempdir

import numpy as np
from reference_data import plane_meshes

from cea.eigen.matching import assign
from cea.petsc import MPI
from comparisons.sweep.page import write_sweep
from comparisons.sweep.points import read_fields
from comparisons.sweep.study import Asked, run
from scenes import assemble, load_scene

MU, P = "contacts.interface.mu", "contacts.interface.P"
MESHES = {
    "fe": {"upper": [8, 2], "lower": [5, 3]},
    "iga": {"upper": [10, 2], "lower": [7, 3]},
}
SMALLER = {"upper": [6, 2], "lower": [4, 2]}
COARSE_DISC = ("bodies.pad.mesh.iga.elements=[3,6,2]", "bodies.disc.mesh.iga.elements=[5,32,1]")


def sine_blocks(backend, *more):
    """Changes of the blocks: friction that flutters at mu0 below one, coarse meshes."""
    return (
        "contacts.interface.mu='sin(pi*x/2)'",
        *(f"bodies.{name}.backend='{backend}'" for name in ("upper", "lower")),
        *plane_meshes(backend, 2, MESHES[backend]),
        *more,
    )


def sweep_of(scene, fields, out, overrides=(), **options):
    """A sweep along fields, whose store is gone."""
    swept = run(Asked(scene, read_fields(fields), tuple(overrides), **options), Path(out))
    if swept.store is not None:
        swept.store.discard()
    return swept


def made_once(folders, asked):
    """Sweeps by their backends, each made once and written, with their folders."""

    @cache
    def of(backend):
        folder = folders.mktemp("sweep") / "out"
        swept = run(asked(backend), folder)
        write_sweep(swept, folder)
        swept.store.discard()
        return swept, folder

    return of


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


def threshold_numbers(backend):
    """What a map of the blocks comes to, and a threshold of the scene, in plain numbers."""
    overrides = ("analysis.max_frequency=0.5", *plane_meshes(backend, 2, SMALLER))
    name = f"thresholds_{MPI.COMM_WORLD.bcast(np.random.default_rng().integers(2**31))}"
    axes, out = ("mu=0:2:9", "P=1:3:2"), Path(gettempdir()) / name
    made = sweep_of("blocks", axes, out, overrides, checks=0, confirm=0)
    record, z = made.record, [eigenvalues(made, i) ** 2 for i in range(18)]
    scene = load_scene("blocks", overrides=list(overrides), backend=backend)
    first = assemble(scene).threshold(MU, real=0.0, flutter=2.0)
    return {
        "modes": [len(each) for each in z],
        "sums": [each.sum().real for each in z],
        "squares": [(each**2).sum().real for each in z],
        "solves": len(record["snapshots"]),
        "values": [each["value"] for each in record["thresholds"]],
        "changes": [each["change"] for each in record["thresholds"]],
        "unresolved": len(record["unresolved"]),
        "first": [first.value, first.frequency],
    }
