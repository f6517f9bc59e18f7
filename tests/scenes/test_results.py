"""What a run gives: shapes, matrices, tables; bodies and contact points used again."""

import numpy as np
import pytest
from blocks import two_blocks
from motions import mode_displacement
from scipy.linalg import eigvals

from cea.errors import InputError
from scenes import read_scene, run_modes, run_scene

GPTS = {"method": "gpts", "points": 3}
MU = "contacts.interface.mu"


def scene_of(backend, **contact):
    data = two_blocks(backend, GPTS, held=True, P=3.0)
    data["contacts"]["interface"] |= contact
    return read_scene(data)


@pytest.fixture(scope="module", params=["fe", "iga"])
def result(request):
    return run_modes(scene_of(request.param))


@pytest.mark.parametrize("chosen", [None, [2, 0], np.array([1])])
def test_shapes_are_those_of_one_vector_at_a_time(result, chosen):
    modes = range(len(result.modes)) if chosen is None else chosen
    for name, body in result.bodies.items():
        expected = np.stack([mode_displacement(result, name, i) for i in modes], axis=2)
        scale = np.abs(expected).max()
        found = result.mode_shapes(name, modes=chosen)
        np.testing.assert_allclose(found, expected, atol=1e-13 * scale)

        values = body.space.volume_cells().straight().values
        at_points = result.mode_shapes(name, values, chosen, everywhere=False)
        assert at_points.shape == (values.shape[0], 3, len(modes))
        for i in range(len(modes)):
            u = values @ expected[..., i]
            np.testing.assert_allclose(at_points[..., i], u, atol=1e-13 * scale)

        points = body.surfaces["z_max"].gauss_points(2)
        on_surface = result.mode_shapes(f"{name}.z_max", points.at, chosen)
        trace = body.surfaces["z_max"].trace(points.at)
        np.testing.assert_array_equal(on_surface, result.mode_shapes(name, trace, chosen))
        u = trace @ expected[..., -1]
        np.testing.assert_allclose(on_surface[..., -1], u, atol=1e-13 * scale)


def test_matrices_have_the_eigenvalues(result):
    matrices = result.matrices()
    assert list(matrices) == ["K", "M", "K_n", "K_f"]
    assert {m.shape for m in matrices.values()} == {(result.system.size,) * 2}
    K = (matrices["K"] + matrices["K_n"] - matrices["K_f"]).toarray()
    found = np.sqrt(-eigvals(K, matrices["M"].toarray()).astype(complex))
    found = np.where(found.imag < 0, -found, found)
    for value in result.eigenvalues:
        assert np.abs(found - value).min() < 1e-7 * abs(value)
    inside = (found.imag > 0) & (found.imag < 2 * np.pi * result.analysis.max_frequency)
    assert inside.sum() == len(result.modes)


def test_bodies_of_other_names_are_refused(result):
    """As long as nobody knows what they were made of."""
    with pytest.raises(InputError, match=r"bodies = \['upper'\]"):
        run_scene(result.scene, bodies={"upper": dict(result.bodies)["upper"]})


@pytest.mark.grid
@pytest.mark.parametrize(
    ("change", "reused"),
    [
        ({"contacts.interface.P": 5.0, MU: 0.2}, {"upper", "lower", "interface"}),
        ({"bodies.upper.damping": {"alpha": 0.1}}, {"upper", "lower", "interface"}),
        ({"contacts.interface.formulation.points": 4}, {"upper", "lower"}),
        ({"bodies.upper.material.nu": 0.2}, {"lower"}),
        ({"bodies.lower.material.E": 3.0}, {"upper"}),
        ({"bodies.upper.springs": [{"surface": "x_min", "stiffness": [1.0] * 3}]}, {"lower"}),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else None,
)
def test_what_the_scene_makes_of_the_same_is_used_again(result, change, reused):
    scene = result.scene.change(change)
    again = run_modes(scene, bodies=result.bodies, interfaces=result.interfaces)
    assert again.eigenvalues == pytest.approx(run_modes(scene).eigenvalues, rel=1e-9, abs=1e-9)
    before, after = (dict(r.bodies) | dict(r.interfaces) for r in (result, again))
    assert {name for name in after if after[name] is before[name]} == reused
