"""What samples of the blocks come to, in plain numbers, in this program and on several ranks."""

from pathlib import Path
from tempfile import gettempdir

import numpy as np
from reference_data import plane_meshes

from cea.petsc import MPI
from comparisons.sweep.distributions import read_distribution
from comparisons.sweep.sample_study import AskedSamples, run_samples

MESHES = {"upper": [4, 1], "lower": [3, 2]}


def numbers():
    """Sums over 300 samples, which fill more than one cell."""
    overrides = ("analysis.max_frequency=0.3", *plane_meshes("iga", 2, MESHES))
    spread = ("mu~uniform:0:0.8", "P~lognormal:1:0.3")
    asked = AskedSamples(
        "blocks", tuple(map(read_distribution, spread)), 300, seed=4, overrides=overrides, checks=0
    )
    name = f"samples_{MPI.COMM_WORLD.bcast(np.random.default_rng().integers(2**31))}"
    data, drawn, found, store = run_samples(asked, Path(gettempdir()) / name)
    store.discard()
    there = np.isfinite(found.frequency)
    return {
        "solves": len(data["snapshots"]),
        "certified": data["certified"],
        "drawn": [sum(each.values) for each in drawn],
        "modes": int(there.sum()),
        "numbers": int(found.number[there].sum()),
        "frequency": float(found.frequency[there].sum()),
        "grows": int(found.grows.sum()),
    }
