"""Small scenes whose every field can be changed: linear, pressed together, damped, rotating."""

from blocks import contact, rectangle, scene_body
from damped_numbers import modally_damped_disc

from scenes.spec.reading import read_scene


def linear(backend):
    """Two rectangles in contact of a given stiffness, with a load that changes no mode."""
    material = {"E": 2.0, "nu": 0.3, "rho": 1.5}
    upper = rectangle(backend, [0.5, 0.3], [3, 1], origin=[0.2, 0.4], material=material)
    lower = rectangle(backend, [1.0, 0.4], [4, 1], material=dict(material))
    upper["supports"] = [{"surface": "y_max"}]
    upper["springs"] = [{"surface": "x_min", "stiffness": [0.3, 0.1]}]
    lower["supports"] = [{"surface": "y_min", "components": ["x", "y"]}]
    along = {"vector": [1.0, 0.0]}
    return {
        "name": "linear",
        "bodies": {"upper": upper, "lower": lower},
        "contacts": {"interface": contact("upper.y_min", "lower.y_max", 3, along, P=3.0)},
        "loads": [{"surface": "upper.x_max", "pressure": 1e-3}],
        "analysis": {"kind": "cea", "max_frequency": 1.3},
    }


def pressed(backend):
    """The same with a law of its closure, pressed together by loads and by a moved support."""
    data = linear(backend) | {"name": "pressed"}
    upper, lower = data["bodies"].values()
    upper["supports"] = [{"surface": "y_max", "components": ["x"]}]
    lower["supports"] = [{"surface": "y_min", "components": ["y", "x"], "value": [1e-4, 0.0]}]
    interface = data["contacts"]["interface"]
    del interface["P"]
    interface |= {"c_n": 1e2, "m_n": 2.0, "added_gap": "0.5*(x-0.45)**2", "mu": 0.2}
    data["loads"] = [
        {"surface": "upper.y_max", "pressure": 1e-2},
        {"surface": "upper.x_max", "force": [1e-4, -1e-3]},
        {"body": "upper", "body_force": [0.0, -1e-3]},
    ]
    return data


def rotating(backend):
    """A ring that turns in another, both damped."""
    outer = scene_body(
        backend,
        {"shape": "ring", "inner_radius": 0.5, "outer_radius": 0.9},
        [1, 8],
        material={"E": 2.0, "nu": 0.3, "rho": 1.0},
        supports=[{"surface": "outer", "components": ["radial"], "origin": [0.0, 0.0]}],
        springs=[{"surface": "outer", "stiffness": [0.2, 0.2]}],
        damping={"ratios": [0.01, 0.02], "frequencies": [0.1, 0.4]},
    )
    inner = outer | {
        "geometry": {"shape": "ring", "inner_radius": 0.2, "outer_radius": 0.5},
        "supports": [],
        "springs": [{"surface": "inner", "stiffness": [0.3, 0.3]}],
        "damping": {"alpha": 0.01, "beta": 0.002},
        "rotation": {"rate": 0.2, "convective_stiffness": True},
    }
    around = {"circumferential_about": [0.0, 0.0, 1.0]}
    sliding = {"pressure": 0.02, "mu_slope": -0.1}
    interface = contact("outer.inner", "inner.outer", 2, around, p=3.0, sliding=sliding)
    return {
        "name": "rotating",
        "bodies": {"outer": outer, "inner": inner},
        "contacts": {"interface": interface},
        "analysis": {"kind": "cea", "max_frequency": 0.3, "min_growth": -0.3},
    }


def rotating_pressed(backend):
    """The same rings without damping, pressed together by a pressure around them."""
    data = rotating(backend) | {"name": "rotating, pressed"}
    for body in data["bodies"].values():
        del body["damping"]
    data["bodies"]["outer"]["supports"] = []
    interface = data["contacts"]["interface"]
    del interface["p"], interface["sliding"]
    interface |= {"c_n": 50.0, "m_n": 2.0, "reach": 0.05}
    data["loads"] = [{"surface": "outer.outer", "pressure": 0.01}]
    return data


def damped(backend):
    """A disc under a pad in space, both with modal damping, friction of a sliding speed."""
    data = modally_damped_disc(backend) | {"name": "damped"}
    del data["bodies"]["disc"]["rotation"]
    data["contacts"]["interface"]["sliding"]["speed"] = 0.3
    return data


SCENES = {made.__name__: made for made in (linear, pressed, rotating, rotating_pressed, damped)}
"""What makes the data of each scene, by its name."""


def scene_of(name, backend):
    """One of the scenes on a backend."""
    return read_scene(SCENES[name](backend))
