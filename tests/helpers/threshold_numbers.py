"""Thresholds of the blocks in plain numbers, in this program and on several ranks."""

from pathlib import Path
from tempfile import gettempdir

import numpy as np
from reference_data import plane_meshes

from cea.petsc import MPI
from comparisons.sweep.points import read_fields
from comparisons.sweep.study import Asked, run
from scenes import assemble, load_scene

MESHES = {"upper": [6, 2], "lower": [4, 2]}


def numbers(backend):
    """Thresholds in mu, of a map and of the assembled scene."""
    overrides = ("analysis.max_frequency=0.5", *plane_meshes(backend, 2, MESHES))
    axes = read_fields(("mu=0:2:9", "P=1:3:2"))
    name = f"thresholds_{MPI.COMM_WORLD.bcast(np.random.default_rng().integers(2**31))}"
    made = run(Asked("blocks", axes, overrides, checks=0, confirm=0), Path(gettempdir()) / name)
    made.store.discard()
    record = made.record
    scene = load_scene("blocks", overrides=list(overrides), backend=backend)
    first = assemble(scene).threshold("contacts.interface.mu", real=0.0, flutter=2.0)
    return {
        "values": [each["value"] for each in record["thresholds"]],
        "changes": [each["change"] for each in record["thresholds"]],
        "unresolved": len(record["unresolved"]),
        "first": [first.value, first.frequency],
    }
