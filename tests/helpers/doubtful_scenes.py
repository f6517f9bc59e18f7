"""Scenes whose numbers, motions or places are unlikely to be meant."""

from blocks import rectangle

from scenes import run_scene
from scenes.spec.reading import read_scene

STEEL, TONNES = {"E": 2.1e11, "rho": 7850.0}, {"E": 2.1e5, "rho": 7.85e-9}


def bar(backend, *, E=2.1e11, rho=7850.0, size=(0.2, 0.02), analysis=None, **others):
    """A bar in plane strain that is held at its left end."""
    material, supports = {"E": E, "nu": 0.0, "rho": rho}, [{"surface": "x_min"}]
    scene = {
        "name": "bar",
        "bodies": {"bar": rectangle(backend, size, [8, 2], material=material, supports=supports)},
        "analysis": analysis or {"kind": "cea", "max_frequency": 2000.0},
    }
    return scene | others


def kinds(warnings):
    return [warning.kind for warning in warnings]


def pulled(backend, strain, E=2.1e11):
    """The bar pulled with a uniform strain: nu = 0, so that u = strain x."""
    data = bar(
        backend,
        E=E,
        analysis={"kind": "static"},
        loads=[{"surface": "bar.x_max", "pressure": -strain * E}],
    )
    return run_scene(read_scene(data))


def two_bars(backend, shift):
    """Two bars of which the second stands somewhere else, without a contact."""
    data = bar(backend)
    other = dict(data["bodies"]["bar"])
    other["geometry"] = {"shape": "rectangle", "size": [0.2, 0.02], "origin": list(shift)}
    data["bodies"]["other"] = other
    return data
