"""What the program found on 2026-11-25, frozen: scenes, figures and claims, studies."""

import numpy as np
import pandas as pd
import pytest
from golden import differences, run_frozen, stored
from mpi import command

from comparisons import agreement, locking, patch_tests
from comparisons.accuracy.cases import measure
from comparisons.paper.claims import judged
from comparisons.paper.study import STUDY as PAPER_STUDY
from comparisons.study.result import read
from comparisons.study.run import run

QUICK = ("blocks_iga", "hertz_cylinder_iga", "patch_test_fe")
"""Frozen scenes that the quick tests run, a second or two each."""
ROUNDING = 1e-9
"""Relative errors below it are rounding, and differ from machine to machine."""


@pytest.mark.parametrize(
    "name",
    [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in stored("scenes")],
)
def test_a_scene_has_its_frozen_numbers(name, tmp_path):
    case = stored("scenes")[name]
    assert list(differences(case, run_frozen(here, case, tmp_path))) == []


def here(*arguments):
    """Run a command line in this process."""
    done = command(*map(str, arguments))
    assert done["code"] == 0, done["out"] + done["err"]


PAPER = read("paper", PAPER_STUDY.shipped)


@pytest.mark.parametrize("table", stored("tables")["paper_numbers"])
def test_figures_of_the_paper_have_their_frozen_numbers(table):
    assert_same(PAPER.frame(table), stored("tables")["paper_numbers"][table])


def test_claims_of_the_paper_have_their_frozen_verdicts():
    """But not how a claim and its measure are worded, which may improve."""
    assert_same(judged(PAPER), stored("tables")["paper_claims"], but=("claim", "measure"))


def assert_same(found, frozen, but=()):
    """Equal words, numbers equal to rounding."""
    expected = pd.DataFrame(frozen).drop(columns=list(but))
    found = found[list(expected)]
    same = {"check_dtype": False, "rtol": 1e-8, "atol": 1e-12}
    pd.testing.assert_frame_equal(found, expected.astype(found.dtypes), **same)


def assert_same_errors(found, expected, rel=1e-3):
    """Errors that are equal, or both rounding; None where an eigenvalue was lost."""
    assert [error is None for error in found] == [error is None for error in expected]
    pairs = [pair for pair in zip(found, expected, strict=True) if pair[1] is not None]
    for one, other in pairs:
        assert abs(one - other) <= max(rel * other, ROUNDING)


@pytest.mark.slow
def test_locking_is_as_frozen(tmp_path):
    result = run(locking.STUDY, locking.Options(), tmp_path / "out")
    found = result.frame()
    rows = found.groupby(["backend", "formulation", "points", "traces"], sort=False)
    for (labels, own), expected in zip(rows, stored("tables")["locking"], strict=True):
        assert labels == tuple(expected[label] for label in rows.keys)
        errors = [None if row["lost"] else row["error"] for row in own.to_dict("records")]
        tied = [expected["tied_error"]] if len(errors) > len(expected["errors"]) else []
        assert_same_errors(errors, [*expected["errors"], *tied])


@pytest.mark.slow
def test_patch_tests_are_as_frozen(tmp_path):
    """Errors of collocation at high P hang on rounding, so a tenth of a per cent is kept."""
    found = patch_tests.runs(run(patch_tests.STUDY, patch_tests.Options(), tmp_path / "out"))
    rows = found.groupby(["interface", "meshes", "formulation", "points"], sort=False)
    for (labels, own), expected in zip(rows, stored("tables")["patch_tests"], strict=True):
        meshes = " on ".join(expected["meshes"])
        assert labels[:2] == (expected["interface"], meshes)
        assert labels[2:] == (expected["formulation"], expected["points"])
        assert own.loc[own["passed"], "P"].tolist() == expected["passes"]
        errors = own["error"].astype(object).where(own["error"].notna(), None)
        assert_same_errors(errors.tolist(), expected["errors"])


@pytest.mark.slow
def test_pairings_of_backends_are_as_frozen(tmp_path):
    only = {"formulation": "mortar"}
    result = run(agreement.STUDY, agreement.Options(), tmp_path / "out", only=only)
    modes = agreement.unstable(result)
    few = result.frame()[:4]
    for name, dofs, expected in zip(
        few["run"], few["dofs"], stored("tables")["pairings"], strict=True
    ):
        assert dofs == expected["dofs"]
        own = modes.loc[modes["run"] == name, ["frequency", "growth"]].to_numpy()
        np.testing.assert_allclose(own, expected["unstable"], rtol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("row", stored("tables")["accuracy_quick"])
def test_errors_against_exact_eigenvalues_are_as_frozen(row):
    """The quick study of accuracy: four digits of each error are kept."""
    case = {"problem": row["problem"], "p": row["stiffness"], **row["method"]}
    found = measure(case, row["refinement"], repeats=1)
    for key in ("dofs", "points", "modes"):
        assert found[key] == row[key]
    for quantity in ("lambda", "frequency", "growth"):
        keys = row[quantity]
        assert_same_errors([found[f"{quantity}_{k}"] for k in keys], list(keys.values()))
