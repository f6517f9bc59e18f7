"""What comes with the project is stored in one form, which says what made it."""

import re
from pathlib import Path

import pytest

from comparisons.accuracy.study import STUDY as ACCURACY
from comparisons.bench.calculix import STUDY as CALCULIX
from comparisons.brake.study import STUDY as BRAKE
from comparisons.paper.study import STUDY as PAPER
from comparisons.study.result import read
from comparisons.study.run import key_of
from comparisons.sweep import page as sweep_page
from comparisons.sweep.study import COMMAND as SWEEP
from scenes.results.record import PROVENANCE, read_record

RECORDS = [
    (PAPER.name, PAPER.shipped / "result.json.gz"),
    (ACCURACY.name, ACCURACY.shipped / "result.json.gz"),
    (BRAKE.name, BRAKE.shipped / "result.json.gz"),
    (CALCULIX.name, CALCULIX.shipped / "result.json.gz"),
    (SWEEP, Path(sweep_page.__file__).with_name("results") / "result.json.gz"),
]


@pytest.mark.parametrize(("command", "file"), RECORDS, ids=lambda value: getattr(value, "name", ""))
def test_a_record_says_what_made_it(command, file):
    data = read_record(file)
    assert set(PROVENANCE) < set(data)
    assert data["command"] == command
    assert data["inputs"]
    assert re.fullmatch("[0-9a-f]{40}", data["commit"])
    assert {"python", "petsc", "slepc", "numpy"} <= set(data["versions"])
    assert data["machine"]["cpus"] > 0


@pytest.mark.parametrize("study", [ACCURACY, CALCULIX, BRAKE, PAPER], ids=lambda s: s.name)
def test_stored_cases_are_those_of_the_default_options(study):
    """So the command takes them: labels, options and scenes agree."""
    options = study.options()
    stored = {case["key"] for case in read(study.name, study.shipped).cases}
    assert stored == {key_of(study, options, dict(case)) for case in study.cases(options)}
