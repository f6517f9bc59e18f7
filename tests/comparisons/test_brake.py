"""The ventilated brake: modes followed over the meshes of the study."""

from types import SimpleNamespace

import pandas as pd
import pytest

from comparisons.brake.study import STUDY, Options, brake_modes
from comparisons.study.run import run


@pytest.mark.slow
def test_modes_are_followed_over_the_meshes(tmp_path):
    """Of linear elements, of which 12,000 dofs hold all parts."""
    bodies = ("disc", "lower_pad", "upper_pad")
    linear = tuple(f"bodies.{name}.mesh.fe.degree=1" for name in bodies)
    result = run(STUDY, Options((0.03, 0.025), overrides=linear), tmp_path / "out")
    frame = brake_modes(result)
    numbers = [int(n) for modes in frame["mode"] for n in modes.split(", ")]
    assert sorted(numbers) == list(range(1, result.frame("brake_runs")["modes"][1] + 1))
    paired = frame[frame["frequency_30mm"].notna()]
    assert len(paired) > 0.8 * len(frame)
    assert (paired["spread"] < 0.03).all()
    assert (frame[frame["verdict"] == "unstable"]["damping_ratio"] < 0).all()


def test_partners_stay_one_row_whatever_they_were_before():
    """Two modes that meet on the finer mesh: their mean is compared with the mean before."""
    rows = [
        *((0.2, f, 0.0, "stable") for f in (50.0, 100.0, 104.0)),
        (0.1, 49.0, 0.0, "stable"),
        (0.1, 101.0, -3.0, "stable"),
        (0.1, 101.0, 3.0, "unstable"),
    ]
    modes = pd.DataFrame(rows, columns=["size", "frequency", "growth", "verdict"])
    groups = [{"size": 0.1, "first": [i], "second": [i]} for i in range(3)]
    tables = {"modes": modes.assign(damping_ratio=0.0), "matches": pd.DataFrame(groups)}
    frame = brake_modes(SimpleNamespace(frame=tables.__getitem__))
    assert list(frame["mode"]) == ["1", "2, 3"]
    last = frame.iloc[1]
    assert last["frequency_200mm"] == pytest.approx(102.0)
    assert last["frequency_100mm"] == pytest.approx(101.0)
    assert last["spread"] == pytest.approx(1 / 101)
    assert (last["growth_200mm"], last["growth_100mm"]) == (0.0, 3.0)
    assert last["verdict"] == "unstable"
