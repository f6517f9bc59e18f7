"""What an interrupted sweep left serves the same scene alone, whatever its name."""

from dataclasses import replace

import numpy as np
import pytest
from reference_data import plane_meshes
from scipy.io import mmwrite
from scipy.sparse import coo_array, diags_array

from comparisons.sweep.axes import read_axis
from comparisons.sweep.fingerprints import fingerprint
from comparisons.sweep.map_study import AskedMap, run_map
from comparisons.sweep.mapped import mapped
from scenes.spec.files import scene_file

MESHES = {
    "fe": {"upper": [6, 2], "lower": [5, 3]},
    "iga": {"upper": [6, 2], "lower": [5, 3]},
}
WAY = "contacts.interface.friction_direction_on_a"
CHANGES = {
    "stiffness of a body": ("bodies.lower.material.E=1.5",),
    "friction the other way": (f"{WAY}={{vector=[-1.0,0.0]}}",),
    "formulation of the contact": ("contacts.interface.formulation={method='gpts',points=3}",),
    "limit of verdicts": ("analysis.growth_threshold=0.01",),
    "window": ("analysis.max_frequency=0.39",),
    "loads, of which it warns": ("loads=[{surface='upper.y_max',pressure=1.0}]",),
}
N = 12


def overrides(backend):
    return (
        "contacts.interface.mu=0.5",
        "analysis.max_frequency=0.4",
        *(f"bodies.{name}.backend='{backend}'" for name in ("upper", "lower")),
        *plane_meshes(backend, 2, MESHES[backend]),
    )


def asked(backend, **options):
    return AskedMap("blocks", (read_axis("mu=0:1:3"),), overrides(backend), checks=0, **options)


def marks(scene, axes, *sets):
    """The fingerprint of a map, made twice."""
    made = []
    for _ in range(2):
        found = mapped(scene, [read_axis(each) for each in axes], sets, None)
        made.append(fingerprint(found))
        found.driver.free()
    assert made[0] == made[1]
    return made[0]


@pytest.mark.grid
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_of_a_changed_scene_is_another(backend, change):
    words = overrides(backend)
    first = marks("blocks", ["mu=0:1:3"], *words)
    assert marks("blocks", ["mu=0:1:3"], *words, *change) != first


@pytest.mark.grid(quick=1)
def test_scene_turned_round_while_its_sweep_was_interrupted_begins_anew(backend, tmp_path):
    """Neither size nor norm of any matrix tells which way a side slides."""
    scene, way = tmp_path / "scene.toml", "vector = [1.0, 0.0]"
    text = scene_file("blocks").read_text()
    assert text.count(way) == 1
    about = replace(asked(backend), scene=scene)
    kept = []
    for written in (text, text, text.replace(way, "vector = [-1.0, 0.0]")):
        scene.write_text(written)
        told, rows, _ = run_map(about, tmp_path / "out")
        kept.append(told["stored_before"] / len(told["snapshots"]))
    assert kept == [0, 1, 0]
    fresh, rows_anew, _ = run_map(about, tmp_path / "fresh")
    assert fresh["snapshots"] == told["snapshots"]
    np.testing.assert_array_equal(rows[0].growth, rows_anew[0].growth)


def written(folder, order, power):
    """A scene of matrices: springs and masses in a row, two of them with friction."""
    folder.mkdir(exist_ok=True)
    K = diags_array([np.full(N - 1, -1.0), 2.0 + 0.1 * np.arange(N), np.full(N - 1, -1.0)],
                    offsets=[-1, 0, 1]).tocsr()  # fmt: skip
    R = coo_array(([1.0], ([3], [4])), shape=(N, N)).tocsr()
    for name, matrix in (("K", K), ("R", R), ("M", diags_array(np.ones(N)).tocsr())):
        mmwrite(folder / f"{name}.mtx", matrix[order][:, order])
    file = folder / "springs.toml"
    file.write_text(f"""
        name = "springs"
        [parameters]
        mu = 0.5
        [files]
        M = "M.mtx"
        K = "K.mtx"
        R = "R.mtx"
        [mass]
        M = 1.0
        [stiffness]
        K = 1.0
        R = "-mu**{power}"
        [analysis]
        kind = "cea"
        max_frequency = 0.2
        """)
    return file


def test_of_changed_files_is_another(tmp_path):
    """Unknowns in another order, and another power of a parameter, both of the same norms."""
    folder, order = tmp_path / "springs", np.arange(N)
    first = marks(written(folder, order, 1), ["parameters.mu=0:1:3"])
    assert marks(written(folder, order[::-1], 1), ["parameters.mu=0:1:3"]) != first
    assert marks(written(folder, order, 2), ["parameters.mu=0:1:3"]) != first
    assert marks(written(folder, order, 1), ["parameters.mu=0:1:3"]) == first
