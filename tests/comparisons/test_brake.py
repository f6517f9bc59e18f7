"""Brakes: modes followed over the meshes of the study; one of mixed elements from a deck."""

from types import SimpleNamespace

import mixed_brake
import numpy as np
import pandas as pd
import pytest

from comparisons.brake.study import SCENE, STUDY, Options, brake_modes
from comparisons.study.run import run
from scenes import SceneError, load_scene, read_scene, run_modes
from scenes.spec.plain import scene_text


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


@pytest.mark.parametrize(
    ("override", "field"),
    [
        ("bodies.disc.backend='iga'", "bodies.disc.backend"),
        ("bodies.disc.mesh.fe={cell='hexahedron',elements=[2,8,2]}", "bodies.disc.mesh.fe.cell"),
        ("bodies.disc.mesh.fe={cell='tetrahedron',elements=[2,8,2]}", "mesh.fe.elements"),
        ("bodies.disc.mesh.fe.degree=3", "bodies.disc.mesh.fe.geometry_degree"),
        ("bodies.disc.geometry.holes=0", "bodies.disc.supports.1.surface"),
    ],
)
def test_discs_that_cannot_be_meshed_are_refused(override, field):
    with pytest.raises(SceneError) as caught:
        load_scene(SCENE, [override])
    assert field in str(caught.value)


LINING = {
    "kind": "orthotropic",
    **{"E_1": 8e9, "E_3": 1.2e9, "nu_12": 0.25, "nu_13": 0.2, "G_13": 1e9, "rho": 2500.0},
    "axes": {"cylindrical_about": [0, 0, 1]},
}
"""Friction material: soft across the lining, stiff in its plane."""


def brake(folder, size, degree):
    """A brake with elements of a size (m) and the degree of its displacements."""
    file = folder / f"brake{size}.inp"
    file.write_text(mixed_brake.brake(size))
    given = mixed_brake.scene(file, friction=0.5, top=9000.0)
    given["bodies"]["pad"]["material"] = LINING
    for body in given["bodies"].values():
        body["mesh"] = {"degree": degree}
    return read_scene(given)


@pytest.mark.slow
def test_finer_meshes_by_hand_lie_in_the_bars(tmp_path, cea):
    """Two digits of every mode and of the growth: a higher degree, and smaller elements.

    Smaller elements have other curved faces, which changes frequencies by 1e-6: more than the
    narrowest of the bars, and less than that of the unstable mode.
    """
    (tmp_path / "brake.toml").write_text(scene_text(brake(tmp_path, 0.012, 2)))
    digits = "--digits 2 --growth-digits 2 --backend fe"
    code, _, told = cea(*f"converge brake.toml {digits} --out bars".split())
    assert not code, told
    found = pd.read_csv(tmp_path / "bars" / "modes.csv")
    assert (found["verdict"] == "▲ unstable").sum() == 1
    for size, degree, compared in ((0.012, 4, found), (0.008, 3, found[found["growth"] != 0])):
        modes = run_modes(brake(tmp_path, size, degree)).modes
        order = np.lexsort((modes.growth_rates, modes.frequencies.round(3)))[compared.index]
        frequencies = np.abs(compared["frequency"] - modes.frequencies[order])
        assert (frequencies < compared["frequency_bar"]).all()
        growths = np.abs(compared["growth"] - modes.growth_rates[order])
        assert (growths <= compared["growth_bar"]).all()
    assert (found["frequency_bar"] < 0.005 * found["frequency"]).all()
    grows = found[found["growth"] > 0]
    assert (grows["growth_bar"] < 0.005 * grows["growth"]).all()
