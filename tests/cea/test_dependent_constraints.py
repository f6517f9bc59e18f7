"""Dependent and unequally stiff contacts beside dense eigenvalues."""

import numpy as np
import pytest
from blocks import rectangle, two_blocks
from covering import covering
from petsc_matrices import to_numpy
from reference_data import plane_meshes

from comparisons.stability.dense import dense_eigenvalues
from scenes import run_modes
from scenes.spec.plain import plain_data
from scenes.spec.reading import load_scene, read_scene

INF = float("inf")


def round_a_point(backend, P, *, sliding=True):
    """Four blocks about a point, one joint sliding with friction or bonded as the others."""
    corners = {"b0": (0.0, 0.0), "b1": (1.0, 0.0), "b2": (1.0, 1.0), "b3": (0.0, 1.0)}
    soft = {"material": {"E": 1.0, "nu": 0.3, "rho": 1.0}}
    bodies = {
        name: rectangle(backend, (1.0, 1.0), [2, 3], origin=origin, **soft)
        for name, origin in corners.items()
    }
    for name in ("b0", "b1"):
        bodies[name]["supports"] = [{"surface": "y_min"}]
    joints = {"c0": ("b0.x_max", "b1.x_min"), "c1": ("b1.y_max", "b2.y_min")}
    joints |= {"c2": ("b2.x_min", "b3.x_max"), "c3": ("b3.y_min", "b0.y_max")}
    bonded = {"formulation": {"method": "bonded"}, "form": "saddle", "P": P}
    contacts = {name: {"a": a, "b": b} | bonded for name, (a, b) in joints.items()}
    if sliding:
        contacts["c0"] |= {"formulation": {"method": "mortar"}, "mu": 0.4}
        contacts["c0"]["friction_direction_on_a"] = {"vector": [0.0, 1.0]}
    analysis = {"kind": "cea", "max_frequency": 0.4}
    return {"name": "four", "bodies": bodies, "contacts": contacts, "analysis": analysis}


def rank_of(system):
    """Number of independent closures of tied contacts."""
    closure = to_numpy(system.pencil().at().multipliers.closure)
    return np.linalg.matrix_rank(closure, tol=1e-10)


def nearest(found, among):
    return np.abs(found[:, None] - among).min(axis=1).max()


@pytest.mark.parametrize(
    ("P", "backend", "sliding"),
    covering([1e8, 1e12, 1e14, 1e20, INF], ["iga", "fe"], [True, False], strength=1),
)
def test_bodies_bonded_round_a_point(backend, P, sliding):
    """As many constraints as are independent; beyond rounding a stiff contact is a tied one."""
    tied = round_a_point(backend, INF, sliding=sliding)
    expected = -(dense_eigenvalues(tied) ** 2)
    result = run_modes(read_scene(round_a_point(backend, P, sliding=sliding)))
    found, rank = -(result.eigenvalues**2), rank_of(result.system)
    assert len(found) >= 8
    inside = expected[(expected.real > 0) & (expected.real < 0.99 * (2 * np.pi * 0.4) ** 2)]
    error = (1e-9 + 3 / P) * np.abs(found).max()
    assert nearest(found, expected) < error
    assert nearest(inside, np.append(found, found.conj())) < error
    matrices = result.modes.pencil.at()
    assert matrices.tied == {1e8: 0, 1e12: 0, 1e20: rank, INF: rank}.get(P, matrices.tied)
    assert matrices.multipliers.size > rank


@pytest.mark.grid
@pytest.mark.parametrize("P", [1e13, INF])
def test_traces_that_supports_hold_on_both_sides(backend, P):
    """Equal meshes, held at one end: a closure there asks what is so already."""
    data = two_blocks(backend, {"method": "bonded"}, mu=0.0, P=P, form="saddle")
    data["bodies"]["lower"]["geometry"] |= {"origin": [0.2, 0.3, 0.0], "size": [0.5, 0.6, 0.4]}
    for body in data["bodies"].values():
        body["supports"] = [{"surface": "x_min"}]
        body["mesh"][backend]["elements"] = [3, 2, 1]
    tied = data | {"contacts": {"interface": data["contacts"]["interface"] | {"P": INF}}}
    result = run_modes(read_scene(data))
    expected, rank = -(dense_eigenvalues(tied) ** 2), rank_of(result.system)
    found = -(result.eigenvalues**2)
    assert nearest(found, expected) < (1e-9 + 30 / P) * np.abs(found).max()
    assert result.system.pencil().at({"contacts.interface.P": INF}).tied == rank
    assert rank < result.system.pencil().at().multipliers.size


@pytest.mark.parametrize(
    ("backend", "form", "contrast"),
    covering(["fe", "iga"], ["penalty", "saddle"], [1e12, 1e15]),
)
def test_stiffnesses_that_differ_along_a_contact(backend, form, contrast):
    overrides = [
        f"contacts.interface.p='where(x<1, 1.0, {contrast!r})'",
        f"contacts.interface.form='{form}'",
        "analysis.max_frequency=0.7",
        *plane_meshes(backend, 2, {"upper": [3, 1], "lower": [4, 1]}),
    ]
    scene = load_scene("blocks", overrides, backend)
    found = -(run_modes(scene).eigenvalues ** 2)
    assert len(found) >= 6
    expected = -(dense_eigenvalues(plain_data(scene)) ** 2)
    distance = np.abs(found[:, None] - expected).min(axis=1)
    assert (distance / np.abs(found)).max() < 1e-9
