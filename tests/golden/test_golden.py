"""What the program found on 2026-11-25, frozen: scenes, and claims of the paper."""

import pandas as pd
import pytest
from golden import GOLDEN, differences, run_frozen, stored
from mpi import command

from comparisons.paper.claims import judged
from comparisons.paper.study import STUDY
from comparisons.study.result import read

QUICK = ("blocks_iga", "hertz_cylinder_iga")
"""Frozen scenes that the quick tests run, a second or two each."""


@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in stored()]
)
def test_a_scene_has_its_frozen_numbers(name, tmp_path):
    case = stored()[name]
    assert list(differences(case, run_frozen(here, case, tmp_path))) == []


def here(*arguments):
    """Run a command line in this process."""
    done = command(*map(str, arguments))
    assert done["code"] == 0, done["out"] + done["err"]


def test_claims_of_the_paper_have_their_frozen_verdicts():
    expected = pd.read_csv(GOLDEN / "claims.csv", dtype={"section": str})
    found = judged(read("paper", STUDY.shipped))[list(expected)]
    pd.testing.assert_frame_equal(found, expected, check_dtype=False, rtol=1e-8, atol=1e-12)
