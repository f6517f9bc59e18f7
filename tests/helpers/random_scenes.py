"""Random small scenes, each made of a seed: what people build, and what they should not.

Arms that lean against the friction, stacks of blocks, bodies without supports, copies that make
multiple eigenvalues, bonded parts, rings; friction to 5, stiffnesses over 18 decades, contrasts of
materials, every formulation and form, both backends and mixtures. Sizes suit dense eigenvalues.
"""

import numpy as np
from random_pieces import Draw, a_body, a_contact, leaning, rectangle, supports

from scenes.spec.reading import Scene, read_scene


def random_scene(seed: int) -> Scene:
    """A scene that is made of nothing but its seed."""
    return read_scene(random_data(seed))


def random_data(seed: int) -> dict:
    """The same as nested dictionaries."""
    draw = Draw(seed)
    kind = draw.choice(_KINDS, weights=_WEIGHTS)
    bodies, contacts = kind(draw)
    if draw.chance(0.15):
        _turn(draw, bodies, contacts)
    return {
        "name": f"random {seed}: {kind.__name__.replace('_', ' ')}",
        "bodies": bodies,
        "contacts": contacts,
        "analysis": _window(draw, bodies),
    }


_SIDES = ["x_min", "x_max"]


def _arm(draw: Draw, x: float, width: float, share: float) -> dict:
    """An arm that stands on y = 0, leaning where it is made of patches."""
    height = width * draw.log(1.0, 6.0)
    on = supports(draw, "y_max", _SIDES, free=0.3)
    if "iga" in draw.backends and draw.chance(0.8):
        lean = height * draw.between(-0.8, 0.8)
        return a_body(draw, leaning(x, 0.0, width, height, lean), share, **on)
    return a_body(draw, rectangle(x, 0.0, width, height), share, **on)


def _base(draw: Draw, share: float, *, free: float = 0.2) -> dict:
    size = draw.length
    on = supports(draw, "y_min", _SIDES, free=free)
    return a_body(draw, rectangle(-1.5 * size, -size, 3 * size, size), share, **on)


def arms_on_base(draw: Draw):
    """An arm on a base, which may jam or be thrown off, or two equal ones: eigenvalues in pairs."""
    width = draw.length * draw.log(0.15, 1.0)
    left = _arm(draw, -width, width, 0.3)
    bodies = {"left": left, "base": _base(draw, 0.5)}
    contacts = {"l": a_contact(draw, bodies, "left.y_min", "base.y_max", width=width)}
    if draw.chance(0.3):
        bodies["right"] = left | {"geometry": _moved(left["geometry"], 1.2 * width)}
        contacts["r"] = contacts["l"] | {"a": "right.y_min"}
    return bodies, contacts


def stack(draw: Draw):
    """One or two blocks on a base, some without supports; side a above or below."""
    free = draw.choice([0.15, 0.8], weights=[0.65, 0.35])
    width, height = draw.length * draw.log(0.3, 2.0), draw.length * draw.log(0.2, 2.0)
    has_top = draw.chance(0.4)  # a surface in contact is not held
    far, sides = ("x_min", ["x_max"]) if has_top else ("y_max", _SIDES)
    on = supports(draw, far, sides, free=free)
    middle = a_body(draw, rectangle(-0.6 * width, 0.0, width, height), 0.4, **on)
    bodies = {"middle": middle, "base": _base(draw, 0.5, free=free)}
    contacts = {"lower": a_contact(draw, bodies, "middle.y_min", "base.y_max", width=width)}
    if draw.chance(0.1) and not contacts["lower"].get("full_pass"):
        reverse = a_contact(draw, bodies, "base.y_max", "middle.y_min", width=width)
        contacts["lower"] = reverse | {"max_missed": 0.95}
    if has_top:
        top = rectangle(-width / 4, height, width / 2, height)
        bodies["top"] = a_body(draw, top, 0.3, **supports(draw, "y_max", _SIDES, free=free))
        contacts["upper"] = a_contact(draw, bodies, "top.y_min", "middle.y_max", width=width / 2)
    return bodies, contacts


def copies(draw: Draw):
    """Equal groups of bodies in one place: every eigenvalue as often as there are groups."""
    count = int(draw.rng.integers(2, 7))
    draw.dofs = max(draw.dofs, 160) // count
    bodies, contacts = draw.choice([arms_on_base, stack])(draw)
    all_bodies, all_contacts = {}, {}
    for i in range(count):
        for name, body in bodies.items():
            all_bodies[f"{name}{i}"] = body
        for name, contact in contacts.items():
            sides = {side: contact[side].replace(".", f"{i}.") for side in "ab"}
            all_contacts[f"{name}{i}"] = contact | sides
    return all_bodies, all_contacts


def bonded_parts(draw: Draw):
    """A body made of two, bonded, on a base."""
    width, height = draw.length * draw.log(0.4, 1.5), draw.length * draw.log(0.3, 1.0)
    on = supports(draw, "y_max", ["x_min"], free=0.4)
    bodies = {
        "left": a_body(draw, rectangle(-width, 0.0, width, height), 0.3, **on),
        "right": a_body(draw, rectangle(0.0, 0.0, width, height), 0.3),
        "base": _base(draw, 0.4),
    }
    contacts = {
        "joint": a_contact(draw, bodies, "left.x_max", "right.x_min", width=height, bonded=True),
        "l": a_contact(draw, bodies, "left.y_min", "base.y_max", width=width),
    }
    if draw.chance(0.7):
        contacts["r"] = a_contact(draw, bodies, "right.y_min", "base.y_max", width=width)
    return bodies, contacts


def two_rings(draw: Draw):
    """A ring turning in another: every eigenvalue but few comes twice."""
    size = draw.length
    outer = {"shape": "ring", "inner_radius": size, "outer_radius": size * draw.between(1.2, 2.0)}
    inner = {"shape": "ring", "inner_radius": size * draw.between(0.3, 0.8), "outer_radius": size}
    bodies = {
        name: a_body(draw, shape, 0.5, supports=[] if draw.chance(0.2) else [{"surface": name}])
        for name, shape in (("outer", outer), ("inner", inner))
    }
    contact = a_contact(draw, bodies, "outer.inner", "inner.outer", width=6.28 * size)
    if "mu" in contact:
        contact["friction_direction_on_a"] = {"circumferential_about": [0.0, 0.0, 1.0]}
    return bodies, {"c": contact}


def boxes(draw: Draw):
    """A small box on a larger one, in space."""
    size, top, bottom = draw.length, [{"surface": "z_max"}], [{"surface": "z_min"}]
    draw.dofs = max(draw.dofs, 170)
    upper = {"shape": "box", "size": [size, 0.8 * size, 0.5 * size], "origin": [0.0, 0.0, 0.0]}
    lower = {
        "shape": "box",
        "size": [2 * size, 1.2 * size, size],
        "origin": [-0.3 * size, -0.2 * size, -size],
    }
    bodies = {
        "upper": a_body(draw, upper, 0.5, supports=[] if draw.chance(0.4) else top),
        "base": a_body(draw, lower, 0.5, supports=[] if draw.chance(0.4) else bottom),
    }
    contact = a_contact(draw, bodies, "upper.z_min", "base.z_max", width=size)
    if "mu" in contact:
        direction = [draw.between(-1, 1), 1.0, 0.0]
        contact["friction_direction_on_a"] = {"vector": direction}
    return bodies, {"c": contact}


_KINDS = {arms_on_base: 36, stack: 34, copies: 9, bonded_parts: 6, two_rings: 4, boxes: 4}
_KINDS, _WEIGHTS = list(_KINDS), list(_KINDS.values())


def _moved(geometry: dict, x: float) -> dict:
    """A shape moved along x."""
    if geometry["shape"] == "rectangle":
        return dict(geometry, origin=[geometry["origin"][0] + x, geometry["origin"][1]])
    patch = geometry["patches"][0]
    points = [[[p[0] + x, p[1]] for p in row] for row in patch["control_points"]]
    return dict(geometry, patches=[dict(patch, control_points=points)])


def _turn(draw: Draw, bodies: dict, contacts: dict) -> None:
    """Turn a plane scene as a whole; what is said of coordinates stays as it is."""
    if any(body["geometry"]["shape"] == "box" for body in bodies.values()):
        return
    angle = draw.between(0.0, 360.0)
    for body in bodies.values():
        body["placement"] = {"angle": angle}
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    for contact in contacts.values():
        vector = contact.get("friction_direction_on_a", {}).get("vector")
        if vector is not None:
            turned = [cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]]
            contact["friction_direction_on_a"] = {"vector": [float(v) for v in turned]}


def _window(draw: Draw, bodies: dict) -> dict:
    """From a few modes to all there are."""
    speeds = [np.sqrt(b["material"]["E"] / b["material"]["rho"]) for b in bodies.values()]
    low, high = draw.choice([(0.05, 3.0), (3.0, 30.0), (1e3, 1e5)], weights=[0.65, 0.25, 0.1])
    frequency = float(f"{min(speeds) / (6 * draw.length) * draw.log(low, high):.6g}")
    analysis = {"kind": "cea", "max_frequency": frequency}
    if draw.chance(0.3):
        threshold = draw.choice([0.0, 1e-4, 1e-2], weights=[0.1, 0.6, 0.3]) * frequency
        analysis["growth_threshold"] = threshold
    return analysis
