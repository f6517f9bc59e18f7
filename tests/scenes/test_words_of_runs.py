"""Words of runs: a block on a spring that groans, whatever its window."""

import pytest

from scenes import open_result, read_scene, run_modes, save_result


def groan(max_frequency, **analysis):
    """A rigid block of 1 kg on a spring, under whose friction of falling slope it groans.

    m x'' - s x' + k x = 0 with m = 1 kg, k = (100 pi)^2 N/m (side 0.01 m of a depth of 1 m) and
    s = 2 N s/m: growth s / 2m = 1 1/s at 50 Hz.
    """
    rectangle = {"shape": "rectangle"}
    return read_scene(
        {
            "name": "groan",
            "bodies": {
                "block": {
                    "backend": "fe",
                    "geometry": rectangle | {"size": [0.04, 0.01], "origin": [0.0, 0.01]},
                    "material": {"E": 2e11, "nu": 0.3, "rho": 2500.0},
                    "springs": [{"surface": "y_max", "stiffness": [2467401.1, 0.0]}],
                    "mesh": {"fe": {"cell": "quadrilateral", "degree": 2, "elements": [4, 1]}},
                },
                "ground": {
                    "backend": "fe",
                    "geometry": rectangle | {"size": [0.1, 0.01], "origin": [-0.03, 0.0]},
                    "material": {"E": 2e11, "nu": 0.3, "rho": 7800.0},
                    "supports": [{"surface": "y_min"}],
                    "mesh": {"fe": {"cell": "quadrilateral", "degree": 2, "elements": [7, 1]}},
                },
            },
            "contacts": {
                "sliding": {
                    "a": "block.y_min",
                    "b": "ground.y_max",
                    "formulation": {"method": "mortar"},
                    "p": 1e12,
                    "mu": 0.3,
                    "friction_direction_on_a": {"vector": [1.0, 0.0]},
                    "sliding": {"pressure": 1e5, "mu_slope": -5e-4},
                }
            },
            "analysis": {"kind": "cea", "max_frequency": max_frequency, **analysis},
        }
    )


@pytest.mark.parametrize("max_frequency", [60.0, 10000.0, 20000.0])
def test_the_word_does_not_depend_on_the_window(max_frequency):
    result = run_modes(groan(max_frequency))
    (row,) = result.table()
    assert row["growth_rate"] == pytest.approx(1.0, rel=1e-3)
    assert row["frequency"] == pytest.approx(50.0, rel=1e-3)
    assert (row["verdict"], result.verdict) == ("unstable", "unstable")
    assert "threshold 1e-4 |lambda|" in result.summary
    assert not result.modes.hints


def test_what_grows_below_the_threshold_grows_slowly():
    result = run_modes(groan(60.0, growth_threshold=5.0))
    assert result.verdict == "grows slowly"
    assert "1 mode grows slowly (fastest +1 1/s); threshold 5 1/s" in result.summary


@pytest.mark.parametrize(("max_frequency", "hinted"), [(47.7, True), (47.5, False)])
def test_growth_up_to_five_percent_above_the_window_is_a_hint(max_frequency, hinted, tmp_path):
    result = run_modes(groan(max_frequency))
    assert result.verdict == "no modes"
    assert "no modes below 47." in result.summary
    assert "the lowest is near 50 Hz" in result.summary
    assert len(result.modes.hints) == hinted
    for hint in result.modes.hints:
        assert "+1 1/s" in hint
        assert str(result).splitlines()[1] == hint
    opened = open_result(save_result(result, tmp_path / "result.json"))
    assert opened.first_lines == result.first_lines
