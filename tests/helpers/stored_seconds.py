"""Seconds of the stored runs of the study of accuracy, beside the estimates for their scenes."""

from functools import cache

from comparisons.accuracy.cases import Method, scene_of
from comparisons.accuracy.problems import PROBLEMS
from comparisons.accuracy.study import STUDY
from comparisons.study.result import read
from scenes.checking.memory import estimated_memory
from scenes.checking.run_time import estimated_seconds


@cache
def estimate(name, method, refinement):
    """Estimate of a case; contact rule and stiffness make no difference to it."""
    scene = scene_of(PROBLEMS[name], method, refinement, 1.0)
    return estimated_seconds(scene, estimated_memory(scene))


def ratios():
    """Median seconds of each run, all stages, relative to the estimate."""
    found = []
    for run in read(STUDY.name, STUDY.shipped).frame().to_dict("records"):
        method = Method(run["backend"], run["degree"], "mortar")
        found.append(run["seconds"] / estimate(run["problem"], method, run["refinement"]))
    return found
