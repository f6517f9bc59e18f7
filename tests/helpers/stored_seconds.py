"""Seconds of the stored runs of the study of accuracy, beside the estimates for their scenes."""

import gzip
import json
from functools import cache
from pathlib import Path

import numpy as np

from comparisons.accuracy.problems import problem
from comparisons.accuracy.study import Case, Method, overrides
from scenes.checking.memory import estimated_memory
from scenes.checking.run_time import estimated_seconds
from scenes.spec.reading import load_scene

STORED = Path(__file__).parents[2] / "comparisons" / "accuracy" / "results" / "result.json.gz"


@cache
def estimate(name, method, refinement):
    """Estimate of a case; contact rule and stiffness make no difference to it."""
    fields = overrides(problem(name), Case(name, method, refinement, 1.0))
    scene = load_scene(name, fields, method.backend)
    return estimated_seconds(scene, estimated_memory(scene))


def ratios():
    """Median seconds of each run, all stages, relative to the estimate."""
    runs = json.loads(gzip.decompress(STORED.read_bytes()))["runs"]
    found = []
    for run in runs:
        method = Method(run["method"]["backend"], run["method"]["degree"], "mortar")
        expected = estimate(run["problem"], method, run["refinement"])
        found.append(float(np.median(run["seconds"])) / expected)
    return found
