"""What comes with the project is stored in one form, says what made it, and is still found."""

import re
from pathlib import Path

import pytest
from same_numbers import assert_same

from comparisons.accuracy.cases import measure
from comparisons.accuracy.problems import PROBLEMS
from comparisons.accuracy.study import STUDY as ACCURACY
from comparisons.bench.calculix import STUDY as CALCULIX
from comparisons.brake.study import STUDY as BRAKE
from comparisons.paper.study import STUDY as PAPER
from comparisons.study.result import read
from comparisons.study.run import key_of
from comparisons.sweep import page as sweep_page
from comparisons.sweep.study import COMMAND as SWEEP
from scenes.results.record import PROVENANCE, read_record

STUDIES = (PAPER, ACCURACY, BRAKE, CALCULIX)
RECORDS = {study.name: study.shipped for study in STUDIES}
RECORDS[SWEEP] = Path(sweep_page.__file__).with_name("results")


@pytest.mark.parametrize("command", RECORDS)
def test_a_record_says_what_made_it(command):
    data = read_record(RECORDS[command] / "result.json.gz")
    assert set(PROVENANCE) < set(data)
    assert data["command"] == command
    assert data["inputs"]
    assert re.fullmatch("[0-9a-f]{40}", data["commit"])
    assert {"python", "petsc", "slepc", "numpy"} <= set(data["versions"])
    assert data["machine"]["cpus"] > 0


@pytest.mark.parametrize(
    ("study", "step"),
    [(PAPER, 5), pytest.param(PAPER, 1, marks=pytest.mark.slow), *((s, 1) for s in STUDIES[1:])],
    ids=lambda each: getattr(each, "name", each),
)
def test_stored_cases_are_those_of_the_default_options(study, step):
    """So the command takes them: labels, options and scenes agree; of the paper any figures."""
    stored = {case["key"] for case in read(study.name, study.shipped).cases}
    assert sum(file.stat().st_size for file in Path(study.shipped).iterdir()) < 3e6

    def keys(options):
        return {key_of(study, options, dict(case)) for case in [*study.cases(options)][::step]}

    own = keys(study.options())
    assert len(own) == len(range(0, len(stored), step))
    assert own <= stored
    if study is PAPER:
        assert set() < keys(study.options(("6", "5"))) < stored


@pytest.mark.slow
@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_case_of_each_problem_has_its_stored_errors(problem, backend):
    """That which was fastest, of those that find every mode; four digits are kept."""
    runs = read(ACCURACY.name, ACCURACY.shipped).frame()
    runs = runs[(runs["problem"] == problem) & (runs["backend"] == backend)]
    expected = runs.dropna(subset="lambda_worst").sort_values("seconds").to_dict("records")[0]
    found = measure(expected, expected["refinement"], repeats=1)
    kept = ("dofs", "points", "modes", "missing", "spurious", "lambda_worst", "growth_median")
    assert_same({key: found[key] for key in kept}, {key: expected[key] for key in kept}, rel=5e-4)
