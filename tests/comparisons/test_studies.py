"""Every study on its quick options: cases are run, everything is shown, nothing failed."""

import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from cea.errors import InputError
from comparisons.cli.study import BENCHMARKS, STUDIES, study_in
from comparisons.damping import MODULUS, Options, exact
from comparisons.damping import STUDY as DAMPING
from comparisons.study.page import write_study
from comparisons.study.result import read
from comparisons.study.run import run
from comparisons.study.sections import rows

# Parts of the others are run by test_formulation_studies.py, test_accuracy.py,
# test_stability.py and test_benchmarks.py.
PLACES = {name: place for name, (place, _) in (STUDIES | BENCHMARKS).items()}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name == "brake" else pytest.mark.slow)
        for name in PLACES
        if name not in ("matrices", "calculix")  # these need files, or another program
    ],
)
def test_quick_options_run_and_show(name, tmp_path):
    study = replace(study_in(PLACES[name]), process=None)
    assert study.name.split()[-1] == name
    result = run(study, study.options(**study.quick), tmp_path)
    assert result.failed().empty
    write_study(study, result, tmp_path)
    stored = read(study.name, tmp_path)
    for section in study.sections:
        frames = [rows(table.frame, stored) for table in section.tables]
        assert not frames or any(len(frame) for frame in frames), section.title
        if section.headline:
            assert section.headline(stored) == section.headline(result)


@pytest.mark.parametrize(
    ("study", "change"),
    [
        ("accuracy", {"problems": ("violin",)}),
        *(("brake", {"sizes": sizes}) for sizes in ((), (0.01, 0.02), (0.01, 0.01), (-0.01,))),
        ("assembly", {"repeats": 0}),
        ("scaling", {"ranks": ()}),
    ],
)
def test_wrong_options_are_refused(study, change):
    with pytest.raises(InputError) as caught:
        study_in(PLACES[study]).options(**change)
    assert [caught.value.field] == list(change)


def test_the_study_of_the_guide_runs(tmp_path):
    """Cut out of docs/how_to_add_a_study.md, at most 60 lines."""
    text = (Path(__file__).parents[2] / "docs" / "how_to_add_a_study.md").read_text()
    program = text.partition("```python\n")[2].partition("```")[0]
    assert len(program.splitlines()) <= 60
    module = ModuleType("friction")
    sys.modules["friction"] = module  # dataclasses look up where they were defined
    exec(program, module.__dict__)
    study = module.STUDY
    result = run(study, study.options(**study.quick), tmp_path)
    assert result.failed().empty
    fe, iga = result.frame()["fastest"]
    assert fe == pytest.approx(iga, rel=0.05)
    assert fe > 0
    assert "Growth over friction" in write_study(study, result, tmp_path).read_text()


# Thresholds of flutter against damping: elastic bodies over the exact lumped system.


@pytest.mark.grid(quick=1)
def test_elastic_bodies_flutter_where_the_lumped_system_does(backend, tmp_path):
    """Up to terms of the order k / E; damped so unlike that half of the friction suffices."""
    options = Options(backends=(backend,), shares=(10.0,), ratios=(0.01,))
    result = run(DAMPING, options, tmp_path)
    (found,) = result.frame()["threshold"]
    assert found == pytest.approx(exact(10.0, 0.01), rel=1 / MODULUS)
    assert found == pytest.approx(0.098287, abs=1e-6)
    assert found < 0.6 * exact(1.0, 0.0)


def test_damping_moves_thresholds_both_ways():
    undamped = exact(1.0, 0.0)
    assert undamped == pytest.approx(0.44 / 2.4)
    assert exact(1.0, 0.1) > undamped > exact(10.0, 0.1)
    assert len(list(DAMPING.cases(Options()))) == 48
