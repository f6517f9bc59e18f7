"""The paper as a study: what comes with the project, verdicts on claims, names of figures."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from paper_figures import made

from cea.errors import InputError
from comparisons.cli.app import main
from comparisons.paper.claims import CLAIMS, Evidence, judged
from comparisons.paper.crowned_pad import COLLOCATION, QUADRATURE
from comparisons.paper.figures import FIGURES, chosen
from comparisons.paper.patch_test import PatchTests
from comparisons.paper.spectra import Diagram, Spectrum, case_row, run_tables
from comparisons.paper.study import STUDY, Options, cases
from comparisons.study.result import StudyResult, read
from comparisons.study.run import run
from comparisons.study.session import Progress
from scenes import run_modes

SHIPPED = read("paper", STUDY.shipped)
CASES = [case["labels"] for case in SHIPPED.cases]
ROUNDING = ("residual", "condition", "seconds", "search_over")
"""Rounding errors and times differ from run to run."""


def test_every_figure_comes_with_the_project(tmp_path):
    """Equal inputs, so that nothing is computed, whichever figures are asked for."""
    started = []
    progress = Progress(step=started.append, stage=lambda stage: None)
    for options in (Options(), Options(("6", "5", "6"))):
        result = run(STUDY, options, tmp_path / "out", progress=progress)
        assert [case["labels"] for case in result.cases] == list(cases(options))
    assert started == []
    assert sum(file.stat().st_size for file in Path(STUDY.shipped).iterdir()) < 3e6


def test_figures_go_by_name():
    assert [figure.name for figure in chosen(("5", "stiff", "4"))] == ["4 and 5", "stiff"]
    assert chosen(()) == list(FIGURES.values())
    assert all(figure.name == name for name, figure in FIGURES.items())
    with pytest.raises(InputError, match="figure = '99': one of 1, 2, 11, 3"):
        chosen(("99",))


def test_claims_rest_on_the_stored_numbers():
    frame = judged(SHIPPED)
    assert list(frame["name"]) == [claim.name for claim in CLAIMS]
    assert np.isfinite(frame.filter(like="_value").to_numpy(dtype=float)).all()


def test_claims_whose_figures_were_not_made_are_left_out():
    some = [case for case in SHIPPED.cases if case["labels"]["figure"] == "15"]
    assert list(judged(StudyResult({"cases": some}))["name"]) == ["places of points"]
    assert judged(StudyResult({"cases": []})).empty


def evidence(figure, **tables):
    labels = {"figure": figure, "mesh": "NURBS"}
    return Evidence(StudyResult({"cases": [{"labels": labels, "tables": tables}]}), "NURBS")


def verdict(name, found):
    """Verdict and number of a claim."""
    return next(claim for claim in CLAIMS if claim.name == name).judged(found)


@pytest.mark.parametrize(
    ("frequency", "both", "expected"),
    [(1.0, 1.0, "does not"), (1.0, 0.0, "depends"), (0.0, 0.0, "holds")],
)
def test_verdict_on_lumped_spectra_follows_the_data(frequency, both, expected):
    row = {"P": 1e9, "number": 1, "share_frequency": frequency, "share_both": both}
    assert verdict("lumped spectra", evidence("6", measures=[row])) == (expected, frequency)


def test_verdicts_on_equilibrium_follow_the_data():
    far = {"pressure_off": (0.1, 0.04), "P_off": (0.0, 0.1), "growth_off": (0.0, 4.0)}
    near = {"pressure_off": (0.01, 0.02), "P_off": (0.0, 0.005), "growth_off": (0.0, -2.0)}

    def crowned(**by_label):
        rows = [
            {"formulation": label, **{name: pair[load] for name, pair in columns.items()}}
            for label, columns in by_label.items()
            for load in (0, 1)
        ]
        return evidence("crowned", crowned=rows)

    found = crowned(**{COLLOCATION: far, QUADRATURE: near})
    assert verdict("equilibrium", found) == ("holds", 2.0)
    assert verdict("p of the scheme", found) == ("depends", 0.1)
    assert verdict("growth of the scheme", found) == ("holds", 2.0)
    swapped = crowned(**{COLLOCATION: near, QUADRATURE: far})
    assert verdict("equilibrium", swapped)[0] == "does not"
    assert verdict("growth of the scheme", swapped)[0] == "does not"


def test_stored_numbers_are_as_the_paper_says():
    rows, numbers = SHIPPED.frame("patch_tests"), SHIPPED.frame("numbers")
    ratios = numbers.query("mesh == 'NURBS' and paper == 'below 1'")
    assert len(ratios) == 5
    assert (ratios["ours"] < 1).all()
    rows = rows.query("mesh == 'NURBS'")
    assert (rows.loc[rows["figure"] == "7", "b_over_a"] > 1).all()
    quoted = rows[rows["paper"].map(lambda said: isinstance(said, float) and said > 1000)]
    tenth = quoted[quoted["figure"] == "10"]
    assert len(tenth) == 3
    np.testing.assert_allclose(tenth["oscillation"], tenth["paper"].astype(float), rtol=0.05)
    assert (rows.loc[rows["paper"] == "machine precision", "oscillation"] < 1e-7).all()
    slopes = numbers.query("figure == 'points'")
    assert len(slopes) == 11
    expected = slopes["remark"].str.extract(r"= (-\d+)")[0].astype(float)
    np.testing.assert_allclose(slopes["ours"], expected, atol=0.3)


def assert_same_rows(found, expected):
    """Equal words; numbers to 1e-8 of the largest of their column."""
    found, expected = pd.DataFrame(found), pd.DataFrame(expected)
    assert list(found) == list(expected)
    for name in set(expected) - set(ROUNDING):
        if expected[name].dtype.kind == "f" or name in ("disc", "pad"):
            same = (frame[name].to_numpy(dtype=float) for frame in (found, expected))
            scale = np.nanmax(np.abs(expected[name].to_numpy(dtype=float)))
            np.testing.assert_allclose(*same, rtol=0, atol=1e-8 * scale + 1e-14, err_msg=name)
        else:
            assert list(found[name]) == list(expected[name]), name


@pytest.mark.slow
@pytest.mark.parametrize("labels", CASES, ids=lambda labels: "-".join(labels.values()))
def test_stored_numbers_are_those_of_the_program(labels):
    """Of a diagram the fastest run, of the patch test one case, of everything else all of it."""
    figure, mesh = FIGURES[labels["figure"]], labels["mesh"]
    stored = next(case for case in SHIPPED.cases if case["labels"] == labels)["tables"]
    if isinstance(figure, Diagram):
        fastest = min(stored["runs"], key=lambda row: row["seconds"])
        P, number = fastest["P"], fastest["number"]
        case = figure.panels(mesh)[P][number]
        run, modes = run_tables(case_row(P, number, case), Spectrum.of(run_modes(case.scene(mesh))))
        for name, found in (("runs", [run]), ("modes", modes)):
            own = [row for row in stored[name] if (row["P"], row["number"]) == (P, number)]
            assert_same_rows(found, own)
        return
    if isinstance(figure, PatchTests):  # the softest, which leaves more than rounding, fast
        row = min(stored["patch_tests"], key=lambda row: (row["P"], row["seconds"]))
        case = next(case for case in figure.cases if case.on(mesh).label == row["case"])
        figure, stored = replace(figure, cases=(case,), ratios=()), {"patch_tests": [row]}
    tables, arrays = made(figure, mesh)
    for name, rows in stored.items():
        assert_same_rows(tables[name], rows)
    for name, array in arrays.items() if not isinstance(figure, PatchTests) else ():
        expected = SHIPPED.array(labels, name)
        rel = 1e-4 if name.endswith("displacement") else 1e-8  # stored rounded
        atol = rel * np.abs(expected).max()
        np.testing.assert_allclose(array, expected, rtol=0, atol=atol, err_msg=name)


def test_claims_and_figures_are_commands(tmp_path, monkeypatch, capsys):
    for command, out in (("paper claims", tmp_path / "claims"), ("paper 1", tmp_path / "figures")):
        monkeypatch.setattr("sys.argv", ["cea", *command.split(), "--out", str(out)])
        with pytest.raises(SystemExit) as end:
            main()
        assert end.value.code in (0, None)
    assert "8 of 20 claims hold on every kind of mesh" in capsys.readouterr().out
    found = pd.read_csv(tmp_path / "claims" / "claims.csv")
    pd.testing.assert_frame_equal(found, judged(SHIPPED), check_dtype=False, rtol=1e-14)
    made = {file.name for file in (tmp_path / "figures").glob("*.png")}
    assert made == {"figure_1.png"}
