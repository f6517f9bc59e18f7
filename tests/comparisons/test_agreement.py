"""Both backends beside each other: pairs of unstable modes."""

import pytest

from comparisons import agreement
from comparisons.agreement import STUDY, Options
from comparisons.study.run import run
from scenes import run_modes

MIXED = "NURBS on finite elements"
"""Pad on disc."""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run(STUDY, Options(**STUDY.quick), tmp_path_factory.mktemp("agreement") / "out")


def test_unstable_modes_of_both_backends_are_paired(result):
    frame = result.frame("agreement")
    (gpts,) = frame[frame["formulation"] == "GPTS"].to_dict("records")
    assert gpts["modal_assurance"] > 0.99
    assert abs(gpts["frequency_change"]) < 0.02
    unstable = agreement.unstable(result)
    assert unstable["run"].nunique() == 5
    assert (unstable["growth"] > 0).all()


def test_pairings_find_the_same_unstable_mode(result):
    runs = result.frame()
    assert runs["complete"].all()
    assert (runs["found"] > 20).all()
    assert runs["dofs"].iloc[-1] > runs["dofs"].iloc[-2]
    pairs = result.frame("agreement").query("formulation == 'mortar'")
    assert len(pairs) == 4
    assert (pairs["modal_assurance"][:3] > 0.99).all()
    # The disc decides: these meshes of it are coarse, and of both backends far apart.
    bounds = [2e-2 if "on NURBS," in c else 1e-3 for c in pairs["compared"]]
    assert (pairs["frequency_change"].abs()[:3] < bounds[:3]).all()


@pytest.fixture
def mixed():
    """The scene of the pairing whose name is ``MIXED``."""
    return agreement.scene({"formulation": "mortar"}, Options(**STUDY.quick))[MIXED]


def test_a_pairing_has_the_backends_of_its_name(mixed):
    assert [mixed.bodies[name].backend for name in ("pad", "disc")] == ["iga", "fe"]


@pytest.mark.slow
def test_a_pairing_is_the_scene_with_mortar(mixed, result):
    modes = run_modes(mixed).modes
    (mode,) = agreement.unstable(result).query("run == @MIXED").to_dict("records")
    (i,) = modes.unstable(10.0).nonzero()[0]
    assert mode["frequency"] == pytest.approx(modes.frequencies[i], rel=1e-9)
    assert mode["growth"] == pytest.approx(modes.growth_rates[i], rel=1e-7)


@pytest.mark.slow
def test_pairings_on_the_meshes_of_the_scene(tmp_path):
    """Six modes agree; the growth of that near a coalescence is another with a higher degree."""
    only = {"formulation": "mortar"}
    result = run(STUDY, Options(), tmp_path / "out", only=only)
    pairs = result.frame("agreement")
    finer = pairs["compared"].str.contains("degree")
    assert (pairs[~finer].groupby("compared").size() == 6).all()
    assert pairs[~finer]["within"].all()
    (changed,) = pairs[finer & (pairs["growth_change"].abs() > 0.15)]["frequency_first"]
    assert changed == pytest.approx(7986, abs=5)
    assert "7 986 Hz" in agreement.headline(result).replace("\u202f", " ")


def test_shapes_of_growing_modes_are_kept(result):
    shown = {
        f"{key}/{mode}"
        for case in result.cases
        for key, modes in case["shapes"]["modes"].items()
        for mode in modes
    }
    assert set(agreement.unstable(result)["shape"]) <= shown
