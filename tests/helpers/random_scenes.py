"""Random small scenes, each made of a seed: what people build, and what they should not.

Arms that lean against the friction, blocks, stacks, bodies without supports, copies that make
multiple eigenvalues, bonded parts, rings; friction to 5, stiffnesses over 18 decades, contrasts of
materials, every formulation and form, both backends and mixtures. Sizes suit dense eigenvalues.
"""

import re

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


def _arm(draw: Draw, x: float, width: float, share: float, *, free: float) -> dict:
    """An arm that stands on y = 0, leaning where it is made of patches."""
    height = width * draw.log(1.0, 6.0)
    on = supports(draw, "y_max", _SIDES, free=free)
    if "iga" in draw.backends and draw.chance(0.8):
        lean = height * draw.between(-0.8, 0.8)
        return a_body(draw, leaning(x, 0.0, width, height, lean), share, **on)
    return a_body(draw, rectangle(x, 0.0, width, height), share, **on)


def _base(draw: Draw, share: float, *, free: float, x=0.0) -> dict:
    size = draw.length
    on = supports(draw, "y_min", _SIDES, free=free)
    return a_body(draw, rectangle(x - 1.5 * size, -size, 3 * size, size), share, **on)


def arm_on_base(draw: Draw):
    """An arm on a base: it may jam, or be thrown off."""
    width = draw.length * draw.log(0.15, 1.0)
    bodies = {
        "arm": _arm(draw, -width / 2, width, 0.4, free=0.3),
        "base": _base(draw, 0.6, free=0.2),
    }
    return bodies, {"c": a_contact(draw, bodies, "arm.y_min", "base.y_max", width=width)}


def two_arms(draw: Draw):
    """Two equal arms on one base: pairs of eigenvalues lie close."""
    width = draw.length * draw.log(0.15, 0.6)
    left = _arm(draw, -width - 0.1 * draw.length, width, 0.25, free=0.3)
    right = dict(left, geometry=_moved(left["geometry"], width + 0.2 * draw.length))
    bodies = {"left": left, "right": right, "base": _base(draw, 0.5, free=0.2)}
    contact = a_contact(draw, bodies, "left.y_min", "base.y_max", width=width)
    return bodies, {"l": contact, "r": dict(contact, a="right.y_min")}


def two_blocks(draw: Draw, free: float = 0.15):
    """A block on another, side a above or below."""
    width = draw.length * draw.log(0.3, 3.0)
    offset = draw.between(0.0, 3 * draw.length - width) if width < 3 * draw.length else 0.0
    on = supports(draw, "y_max", _SIDES, free=free)
    geometry = rectangle(-1.5 * draw.length + offset, 0.0, width, draw.length * draw.log(0.2, 2))
    bodies = {"upper": a_body(draw, geometry, 0.5, **on), "base": _base(draw, 0.5, free=free)}
    contact = a_contact(draw, bodies, "upper.y_min", "base.y_max", width=width)
    if draw.chance(0.1) and not contact.get("full_pass"):
        reverse = a_contact(draw, bodies, "base.y_max", "upper.y_min", width=width)
        contact = reverse | {"max_missed": 0.95}
    return bodies, {"c": contact}


def free_blocks(draw: Draw):
    """Two blocks, most of them without supports."""
    return two_blocks(draw, free=0.8)


def stack(draw: Draw):
    """Three bodies, each on the next."""
    width, height = draw.length * draw.log(0.4, 1.5), draw.length * draw.log(0.2, 1.0)
    middle = rectangle(-width / 2, 0.0, width, height)
    top = rectangle(-width / 4, height, width / 2, height)
    on = supports(draw, "y_max", _SIDES, free=0.4)
    bodies = {
        "top": a_body(draw, top, 0.3, **on),
        "middle": a_body(draw, middle, 0.4, **supports(draw, "x_min", ["x_max"], free=0.8)),
        "base": _base(draw, 0.4, free=0.2),
    }
    return bodies, {
        "upper": a_contact(draw, bodies, "top.y_min", "middle.y_max", width=width / 2),
        "lower": a_contact(draw, bodies, "middle.y_min", "base.y_max", width=width),
    }


def one_on_two(draw: Draw):
    """A beam across two bodies, which are side a."""
    size = draw.length
    beam = rectangle(-1.5 * size, 0.0, 3 * size, size * draw.log(0.2, 1.0))
    on = supports(draw, "y_max", _SIDES, free=0.6)
    bodies = {"beam": a_body(draw, beam, 0.4, **on)}
    contacts = {}
    for name, x in (("left", -1.3 * size), ("right", 0.4 * size)):
        post = rectangle(x, -size, 0.8 * size, size)
        on = supports(draw, "y_min", _SIDES, free=0.2)
        bodies[name] = a_body(draw, post, 0.3, **on)
        contacts[name] = a_contact(draw, bodies, f"{name}.y_max", "beam.y_min", width=0.8 * size)
    return bodies, contacts


def copies(draw: Draw):
    """Equal pairs of bodies that do not touch each other: every eigenvalue as often as pairs."""
    count = int(draw.rng.integers(2, 7))
    draw.dofs = max(draw.dofs, 160) // count
    bodies, contacts = draw.choice([arm_on_base, two_blocks, free_blocks])(draw)
    if any("radial" in s.get("components", ()) for b in bodies.values() for s in b["supports"]):
        return bodies, contacts  # their axis would not move along
    step = draw.choice([0.0, 8.0 * draw.length])  # in one place they are equal to the last bit
    all_bodies, all_contacts = {}, {}
    for i in range(count):
        for name, body in bodies.items():
            geometry = _moved(body["geometry"], i * step)
            all_bodies[f"{name}{i}"] = dict(body, geometry=geometry)
        for name, contact in contacts.items():
            sides = {s: contact[s].replace(".", f"{i}.") for s in "ab"}
            fixed = {k: v for k, v in contact.items() if not isinstance(v, str) or k == "form"}
            varying = {k: v for k, v in contact.items() if k in ("p", "mu") and k not in fixed}
            start = f"(x - {i * step})"
            moved = {k: re.sub(r"\bx\b", start, v) for k, v in varying.items()}
            all_contacts[f"{name}{i}"] = fixed | moved | sides
    return all_bodies, all_contacts


def bonded_parts(draw: Draw):
    """A body made of two, bonded, on a base."""
    width, height = draw.length * draw.log(0.4, 1.5), draw.length * draw.log(0.3, 1.0)
    on = supports(draw, "y_max", ["x_min"], free=0.4)
    bodies = {
        "left": a_body(draw, rectangle(-width, 0.0, width, height), 0.3, **on),
        "right": a_body(draw, rectangle(0.0, 0.0, width, height), 0.3),
        "base": _base(draw, 0.4, free=0.2),
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


_KINDS = {
    arm_on_base: 28, two_arms: 8, two_blocks: 14, free_blocks: 12, stack: 8, one_on_two: 7,
    copies: 9, bonded_parts: 6, two_rings: 4, boxes: 4,
}  # fmt: skip
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
