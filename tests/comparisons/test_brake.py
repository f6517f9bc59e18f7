"""The study of the ventilated brake on few elements: meshes matched, what is stored."""

from types import SimpleNamespace

import pandas as pd
import pytest

from cea.errors import InputError
from comparisons.brake.study import SCENE, STUDY, Options, brake_modes, scene
from comparisons.study.run import run
from scenes.checking.memory import dofs_of
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

BODIES = ("disc", "lower_pad", "upper_pad")
LINEAR = tuple(f"bodies.{name}.mesh.fe.degree=1" for name in BODIES)
ROUGH = Options(sizes=(0.03, 0.025), overrides=LINEAR)
"""Linear elements, of which 12,000 dofs hold all parts."""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """The study on rough meshes."""
    return run(STUDY, ROUGH, tmp_path_factory.mktemp("brake") / "out")


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The study of a disc without vanes and holes, of a tenth of the dofs."""
    return run(STUDY, Options(**STUDY.quick), tmp_path_factory.mktemp("plain") / "out")


def test_every_run_is_in_the_record_with_its_warnings(plain):
    assert plain.failed().empty
    assert [case["labels"]["size"] for case in plain.cases] == [0.04, 0.03]
    assert [len(case["runs"]) for case in plain.cases] == [1, 1], "no mesh is run twice"
    assert "short-modes" in {w["kind"] for run in plain.runs() for w in run["warnings"]}


@pytest.mark.slow
def test_modes_are_followed_over_the_meshes(result):
    frame = brake_modes(result)
    numbers = [int(n) for modes in frame["mode"] for n in modes.split(", ")]
    assert sorted(numbers) == list(range(1, result.frame("brake_runs")["modes"][1] + 1))
    paired = frame[frame["frequency_30mm"].notna()]
    assert len(paired) > 0.8 * len(frame)
    assert (paired["spread"] < 0.03).all()
    assert (frame[frame["verdict"] == "unstable"]["damping_ratio"] < 0).all()


def test_partners_stay_one_row_whatever_they_were_before():
    """Two modes that meet on the finer mesh: their mean is compared with the mean before."""
    coarse = [(50.0, 0.0, "stable"), (100.0, 0.0, "stable"), (104.0, 0.0, "stable")]
    fine = [(49.0, 0.0, "stable"), (101.0, -3.0, "stable"), (101.0, 3.0, "unstable")]
    modes = pd.DataFrame(
        [
            {"size": size, "frequency": f, "growth": g, "damping_ratio": 0.0} | {"verdict": verdict}
            for size, rows in ((0.2, coarse), (0.1, fine))
            for f, g, verdict in rows
        ]
    )
    groups = [{"size": 0.1, "first": [i], "second": [i]} for i in range(3)]
    tables = {"modes": modes, "matches": pd.DataFrame(groups)}
    made = SimpleNamespace(frame=tables.__getitem__)
    frame = brake_modes(made)
    assert list(frame["mode"]) == ["1", "2, 3"]
    last = frame.iloc[1]
    assert last["frequency_200mm"] == pytest.approx(102.0)
    assert last["frequency_100mm"] == pytest.approx(101.0)
    assert last["spread"] == pytest.approx(1 / 101)
    assert (last["growth_200mm"], last["growth_100mm"]) == (0.0, 3.0)
    assert last["verdict"] == "unstable"


@pytest.mark.parametrize("sizes", [(), (0.01, 0.02), (0.01, 0.01), (-0.01,)])
def test_sizes_that_do_not_fall_are_refused(sizes):
    with pytest.raises(InputError) as caught:
        Options(sizes)
    assert caught.value.field == "sizes"


def test_the_estimate_knows_how_fine_the_disc_is():
    """Its dofs are those of the mesh, whatever the size: walls and holes bound that."""
    bodies = scene({"size": 0.0055}, Options()).bodies.values()
    assert sum(map(dofs_of, bodies)) == pytest.approx(483_000, rel=0.25)


@pytest.mark.parametrize(
    ("override", "field"),
    [
        ("bodies.disc.backend='iga'", "bodies.disc.backend"),
        ("bodies.disc.mesh.fe={cell='hexahedron',elements=[2,8,2]}", "bodies.disc.mesh.fe.cell"),
        ("bodies.disc.mesh.fe={cell='tetrahedron',elements=[2,8,2]}", "mesh.fe.elements"),
        ("bodies.disc.mesh.fe.degree=3", "bodies.disc.mesh.fe.geometry_degree"),
        ("bodies.disc.geometry.vanes=0", "vanes"),
        ("bodies.disc.geometry.holes=0", "bodies.disc.supports.1.surface"),
    ],
)
def test_discs_that_cannot_be_meshed_are_refused(override, field):
    with pytest.raises(SceneError) as caught:
        load_scene(SCENE, [override])
    assert field in str(caught.value)
