"""Both backends beside each other: patch test against the prototype, pairs of unstable modes."""

import numpy as np
import pytest

from comparisons import agreement
from comparisons.agreement import EXPECTED, STUDY, Options
from comparisons.study.run import run


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run(STUDY, Options(**STUDY.quick), tmp_path_factory.mktemp("agreement") / "out")


def test_oscillations_are_those_of_the_prototype(result):
    frame = result.frame("patch_test")
    ratios = frame["ratio"].dropna()
    assert len(ratios) == 3
    np.testing.assert_allclose(ratios, 1.0, atol=1e-3)
    assert (frame["oscillation"] == frame[["oscillation_a", "oscillation_b"]].max(axis=1)).all()
    assert set(EXPECTED.values()) >= set(frame["expected"].dropna())


def test_unstable_modes_of_both_backends_are_paired(result):
    frame = agreement.agreement(result)
    gpts = frame[frame["formulation"] == "GPTS"]
    assert list(gpts["found_by"]) == ["both"]
    assert gpts["modal_assurance"].iloc[0] > 0.99
    assert abs(gpts["frequency_difference"].iloc[0]) < 0.02
    unstable = agreement.unstable(result)
    assert set(unstable["backend"]) == {"fe", "iga"}
    assert (unstable["growth"] > 0).all()
    assert result.frame("windows")["complete"].all()


def test_errors_of_the_disc_alone_are_against_the_reference(result):
    frame = agreement.disc_alone(result)
    assert len(frame) == len(agreement.DISC_MESHES)
    assert "reference" not in set(frame["line"])
    assert (frame["median_error"] <= frame["worst_error"]).all()
    best = frame.loc[frame["worst_error"].idxmin()]
    assert best["line"] == "NURBS, degree 4"
    assert best["worst_error"] < 0.02
    (differences,) = agreement.backend_differences(result).to_dict("records")
    assert (differences["fe"], differences["iga"]) == ("4 x 24 x 1", "4 x 16 x 1")


def test_shapes_of_growing_modes_are_kept(result):
    shown = {
        f"{key}/{mode}"
        for case in result.cases
        for key, modes in case["shapes"]["modes"].items()
        for mode in modes
    }
    assert set(agreement.unstable(result)["shape"]) <= shown
