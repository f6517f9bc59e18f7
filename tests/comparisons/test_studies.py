"""Every study on its quick options: cases are run, everything is shown, nothing failed."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from cea.errors import InputError
from comparisons.cli.study import BENCHMARKS, STUDIES, study_in
from comparisons.damping import MODULUS, Options, dampings, evaluate, exact, scene
from comparisons.damping import STUDY as DAMPING
from comparisons.study.page import write_study
from comparisons.study.result import read
from comparisons.study.run import run
from comparisons.study.sections import rows
from comparisons.study.session import Session

# `make stability ARGS=--quick` is a step of its own; test_stability.py runs one of its cases.
LONG = ("stability", "accuracy", "agreement")
QUICK = [
    *(
        pytest.param(name, place, marks=pytest.mark.slow if name in LONG else ())
        for name, (place, _) in STUDIES.items()
    ),
    ("bench scaling", BENCHMARKS["scaling"][0]),
    *(
        pytest.param(f"bench {name}", BENCHMARKS[name][0], marks=pytest.mark.slow)
        for name in ("solve", "assembly")  # test_benchmarks.py runs part of each
    ),
]


@pytest.mark.parametrize(("name", "place"), QUICK)
def test_quick_options_run_and_show(name, place, tmp_path):
    study = study_in(place)
    assert study.name == name
    result = run(study, study.options(**study.quick), tmp_path)
    assert result.failed().empty
    write_study(study, result, tmp_path)
    stored = read(name, tmp_path)
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
    place, _ = (STUDIES | BENCHMARKS)[study]
    with pytest.raises(InputError) as caught:
        study_in(place).options(**change)
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


def test_dampings_have_their_mean_and_their_share():
    c1, c2 = dampings(3.0, 0.02)
    first, second = c1 / 2, c2 / 2 / 1.2
    assert second / first == pytest.approx(3.0)
    assert (first + second) / 2 == pytest.approx(0.02)


@pytest.mark.grid(quick=1)
def test_elastic_bodies_flutter_where_the_lumped_system_does(backend):
    """Up to terms of the order k / E; damped so unlike that half of the friction suffices."""
    session, case = Session(Options()), {"backend": backend, "share": 10.0, "ratio": 0.01}
    session.begin(scene(case, Options()))
    found = evaluate(case, session)["threshold"]
    assert found == pytest.approx(exact(10.0, 0.01), rel=1 / MODULUS)
    assert found == pytest.approx(0.098287, abs=1e-6)
    assert found < 0.6 * exact(1.0, 0.0)


def test_damping_moves_thresholds_both_ways():
    undamped = exact(1.0, 0.0)
    assert undamped == pytest.approx(0.44 / 2.4)
    assert exact(1.0, 0.1) > undamped > exact(10.0, 0.1)
    assert len(list(DAMPING.cases(Options()))) == 48
