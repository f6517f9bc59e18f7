"""Every study on its quick options: cases are run, everything is shown, nothing failed."""

import pytest

from comparisons.cli.study import STUDIES, study_at
from comparisons.study.page import write_study
from comparisons.study.result import read
from comparisons.study.run import run


@pytest.mark.parametrize("name", STUDIES)
def test_quick_options_run_and_show(name, tmp_path):
    study = study_at(f"comparisons.{STUDIES[name][0]}")
    assert study.name == name
    result = run(study, study.options(**study.quick), tmp_path)
    assert result.failed().empty
    write_study(study, result, tmp_path)
    stored = read(name, tmp_path)
    for section in study.sections:
        frames = [table.frame(stored) for table in section.tables]
        assert not frames or any(len(frame) for frame in frames), section.title
        if section.headline:
            assert section.headline(stored) == section.headline(result)
