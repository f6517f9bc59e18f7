"""Stored numbers are still those of the program: of each stored file something cheap is run anew.

What is stored cannot outlive what made it: seconds, versions and rounding errors (residuals) may
differ, nothing else.
"""

import json
from functools import cache

import numpy as np
import pytest
from same_numbers import assert_same

from comparisons.accuracy.errors import measure
from comparisons.accuracy.problems import PROBLEMS
from comparisons.accuracy.study import STUDY as ACCURACY
from comparisons.kit.progress import Progress
from comparisons.paper.common.store import STORED, fingerprint
from comparisons.paper.disc_pad.runs import RUNS
from comparisons.paper.disc_pad.stability_diagram import StabilityFigure
from comparisons.paper.patch_test.case import run_case
from comparisons.paper.patch_test.figures import PatchTestFigure
from comparisons.paper.patch_test.quadrature import QuadratureStudy, fitted_slope
from comparisons.paper.registry import FIGURES
from comparisons.reference.study import LEVELS, STUDY, graded_scene
from comparisons.study.result import read
from scenes import run_modes
from scenes.results.record import read_record

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)
ESTIMATES = {"growth_uncertainty", "uncertainty", "verdict", "residual", "condition"}
"""Of rounding errors, by what happened to be found beside each mode, and what follows from them."""
NOT_NUMBERS = {"seconds", "timings", "versions", "machine"} | ESTIMATES
DIGITS = 5e-4
"""The study of accuracy keeps four digits."""


@cache
def stored(name, backend):
    return read_record(STORED / f"figure_{name}_{backend}.json.gz")


def every_stored_figure():
    """Name and backend of each file."""
    names = sorted(file.name.removesuffix(".json.gz") for file in STORED.glob("*.json.gz"))
    return [tuple(name.removeprefix("figure_").rsplit("_", 1)) for name in names]


def numbers(data):
    """Plain data without what differs from run to run."""
    if isinstance(data, dict):
        return {key: numbers(value) for key, value in data.items() if key not in NOT_NUMBERS}
    return [numbers(value) for value in data] if isinstance(data, list) else data


def cheapest_patch_case(figure, backend, data):
    """Of the softest contact, which leaves more than rounding, the case that ran fastest."""
    cases = figure.on(backend)
    label = min(data["cases"], key=lambda each: (cases[each].P, data["cases"][each]["seconds"]))
    found, _ = run_case(cases[label], backend)
    expected = data["cases"][label]
    assert_same(found.pop("map"), expected["map"], "map", rel=1e-4)  # it is stored rounded
    return found, {key: value for key, value in expected.items() if key != "map"}


def cheapest_spectrum(figure, data):
    """The case that ran fastest, on whatever kind of mesh."""
    _, family, panel, label = min(
        (case["seconds"], family, i, label)
        for family, panels in data["families"].items()
        for i, panel in enumerate(panels)
        for label, case in panel["cases"].items()
    )
    case = figure.panels[panel].on(family)[label]
    return RUNS.spectrum(case, family).data, data["families"][family][panel]["cases"][label]


def cheapest_space(study, backend, data):
    """The lowest degree."""
    space, expected = next(iter(data["spaces"].items()))
    errors = study.errors(int(space[1]), expected["continuity"], backend)
    found = expected | {"oscillation": errors, "slope": fitted_slope(study.points, errors)}
    return found, expected


def test_every_figure_is_stored():
    found = {name for name, _ in every_stored_figure()}
    assert found == set(FIGURES)
    for name, backend in every_stored_figure():
        assert stored(name, backend)["fingerprint"] == fingerprint(FIGURES[name].inputs(backend))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "backend"), every_stored_figure())
def test_a_case_of_each_figure_gives_its_stored_numbers(name, backend):
    figure, data = FIGURES[name], stored(name, backend)
    if isinstance(figure, PatchTestFigure):
        found, expected = cheapest_patch_case(figure, backend, data)
    elif isinstance(figure, StabilityFigure):
        found, expected = cheapest_spectrum(figure, data)
    elif isinstance(figure, QuadratureStudy):
        found, expected = cheapest_space(figure, backend, data)
    else:
        found = figure.compute(backend, QUIET)
        expected = {key: data[key] for key in found}
    found = json.loads(json.dumps(found))
    assert_same(numbers(found), numbers(expected), f"figure {name}, {backend}", rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_case_of_each_problem_has_its_stored_errors(problem, backend):
    """That which was fastest, of those that find every mode."""
    runs = read(ACCURACY.name, ACCURACY.shipped).frame()
    runs = runs[(runs["problem"] == problem) & (runs["backend"] == backend)]
    expected = runs.dropna(subset="lambda_worst").sort_values("seconds").to_dict("records")[0]
    found = measure(expected, expected["refinement"], repeats=1)
    kept = ("dofs", "points", "modes", "missing", "spurious", "lambda_worst", "growth_median")
    assert_same({key: found[key] for key in kept}, {key: expected[key] for key in kept}, rel=DIGITS)


@pytest.mark.slow
def test_the_cheapest_run_of_the_reference_has_its_stored_modes():
    coarse = f"backend == 'iga' and degree == {LEVELS['iga'][0].degree}"
    stored = read("reference", STUDY.shipped)
    expected = stored.frame("run_modes").query(coarse)
    result = run_modes(graded_scene("iga", LEVELS["iga"][0]))
    assert [result.system.size] == stored.frame("runs").query(coarse)["dofs"].tolist()
    for quantity, values in (
        ("frequency", result.modes.frequencies),
        ("growth", result.modes.growth_rates),
    ):
        kept = expected[quantity].to_numpy()
        np.testing.assert_allclose(values, kept, rtol=1e-8, atol=1e-8 * np.abs(kept).max())
