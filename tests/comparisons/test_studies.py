"""Every study on its quick options: cases are run, everything is shown, nothing failed."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from cea.errors import InputError
from comparisons.cli.study import BENCHMARKS, STUDIES, study_in
from comparisons.study.page import write_study
from comparisons.study.result import read
from comparisons.study.run import run
from comparisons.study.sections import rows

# `make stability ARGS=--quick` is a step of its own; test_stability.py runs one of its cases.
LONG = ("stability", "accuracy", "agreement")
QUICK = [
    *(
        pytest.param(name, place, marks=pytest.mark.slow if name in LONG else ())
        for name, (place, _) in STUDIES.items()
    ),
    *((f"bench {name}", BENCHMARKS[name][0]) for name in ("solve", "scaling")),
    pytest.param("bench assembly", BENCHMARKS["assembly"][0], marks=pytest.mark.slow),
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
        *(("accuracy", {name: ("violin",)}) for name in ("problems", "parts")),
        *(("brake", {"sizes": sizes}) for sizes in ((), (0.01, 0.02), (0.01, 0.01), (-0.01,))),
        ("assembly", {"repeats": 0}),
        ("assembly", {"boxes": (0, 1, 1)}),
        ("solve", {"size": "huge"}),
        ("scaling", {"ranks": ()}),
        ("matrices", {"repeats": 0}),
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
