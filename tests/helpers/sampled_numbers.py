"""What samples of the blocks come to, in plain numbers, in this program and on several ranks."""

from pathlib import Path
from tempfile import gettempdir

import numpy as np
from reference_data import plane_meshes

from cea.petsc import MPI
from comparisons.sweep.points import read_fields
from comparisons.sweep.study import Asked, run

MESHES = {"upper": [4, 1], "lower": [3, 2]}


def numbers():
    """Sums over 300 samples, which fill more than one part."""
    overrides = ("analysis.max_frequency=0.3", *plane_meshes("iga", 2, MESHES))
    spread = read_fields(("mu~uniform:0:0.8", "P~lognormal:1:0.3"))
    asked = Asked("blocks", spread, overrides, samples=300, seed=4, checks=0)
    name = f"samples_{MPI.COMM_WORLD.bcast(np.random.default_rng().integers(2**31))}"
    made = run(asked, Path(gettempdir()) / name)
    made.store.discard()
    there = made.spectra.there
    return {
        "solves": len(made.record["snapshots"]),
        "certified": made.record["certified"],
        "drawn": made.points.values.sum(axis=0).tolist(),
        "modes": int(there.sum()),
        "numbers": int(made.spectra.number[there].sum()),
        "frequency": float(made.spectra.frequency[there].sum()),
        "grows": made.record["any"]["grows"],
    }
