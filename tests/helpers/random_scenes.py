"""Random small scenes, each made of a seed: what people build, and what they should not.

Arms that lean against the friction, stacks of blocks, bodies without supports, copies that make
multiple eigenvalues, bonded parts, rings; friction to 5, stiffnesses over 18 decades, contrasts of
materials, every formulation and form, both backends and mixtures. Sizes suit dense eigenvalues.
"""

import numpy as np

from cea.contact.formulations import registered
from scenes.spec.contact import suits
from scenes.spec.reading import Scene, read_scene

MOST_DOFS = 400
"""Dofs of a scene, those that supports take out included, stay about below."""


class Draw:
    """Random numbers of one scene, its units and what its bodies share."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.length = self.choice([1.0, 0.05], weights=[0.8, 0.2])
        self.modulus = self.choice([1.0, 1e5, 2e11], weights=[0.7, 0.15, 0.15])
        self.density = self.choice([1.0, 7800.0], weights=[0.7, 0.3])
        self.contrast = self.choice([0.5, 2.0, 6.0], weights=[0.4, 0.4, 0.2])
        self.backends = self.choice([["fe"], ["iga"], ["fe", "iga"]], weights=[0.35, 0.35, 0.3])
        self.dofs = int(self.log(60.0, 260.0) if self.chance(0.9) else self.log(200.0, MOST_DOFS))
        self.has_friction = not self.chance(0.15)

    def choice(self, options, weights=None):
        """One of some."""
        total = None if weights is None else np.asarray(weights) / np.sum(weights)
        return options[int(self.rng.choice(len(options), p=total))]

    def chance(self, part: float) -> bool:
        """True in a part of the cases."""
        return bool(self.rng.random() < part)

    def log(self, low: float, high: float) -> float:
        """A number whose logarithm is uniform, with six digits."""
        return float(f"{np.exp(self.rng.uniform(np.log(low), np.log(high))):.6g}")

    def between(self, low: float, high: float) -> float:
        """A uniform number, with six digits."""
        return float(f"{self.rng.uniform(low, high):.6g}")

    def material(self) -> dict:
        """Moduli apart by as much as the scene says."""
        spread = 10.0 ** self.rng.uniform(-self.contrast / 2, self.contrast / 2)
        return {
            "E": float(f"{self.modulus * spread:.6g}"),
            "nu": self.choice([0.0, 0.3, 0.45, 0.49], weights=[0.2, 0.5, 0.2, 0.1]),
            "rho": self.density * self.log(0.3, 3.0),
        }


def a_body(draw: Draw, geometry: dict, share: float, *, supports=(), springs=(), backend=None):
    """A body of a share of the dofs, on a backend of the scene."""
    backend = backend or draw.choice(draw.backends)
    if geometry["shape"] == "patches":
        backend = "iga"
    body = {
        "backend": backend,
        "geometry": geometry,
        "material": draw.material(),
        "supports": list(supports),
        "mesh": {backend: _mesh(draw, backend, geometry["shape"], share * draw.dofs)},
    }
    if springs:
        body["springs"] = list(springs)
    return body


def _mesh(draw: Draw, backend: str, shape: str, most: float) -> dict:
    """A random mesh of at most so many dofs, or the smallest there is."""
    dim, closed = (3 if shape == "box" else 2), shape == "ring"
    smallest = None
    for _ in range(30):
        degree = draw.choice([1, 2, 3], weights=[0.25, 0.55, 0.2] if dim == 2 else [0.6, 0.4, 0.0])
        elements = [int(n) for n in draw.rng.integers(1, 10 if dim == 2 else 4, dim)]
        if closed:
            elements = [min(elements[0], 2), 4 * int(draw.rng.integers(2, 5))]
        if backend == "iga":
            degree = max(degree, 2) if closed else degree  # circles have two
            counts = [n + degree for n in elements]
            made = {"degree": [degree] * dim, "elements": elements}
        else:
            counts = [n * degree + 1 for n in elements]
            cells = ("quadrilateral", "triangle") if dim == 2 else ("hexahedron", "tetrahedron")
            made = {"cell": draw.choice(cells), "degree": degree, "elements": elements}
        dofs = dim * int(np.prod(counts))
        if smallest is None or dofs < smallest[0]:
            smallest = dofs, made
        if 0.3 * most < dofs <= most:
            return made
    return smallest[1]


def a_contact(draw: Draw, bodies: dict, a: str, b: str, *, width: float, bonded=False) -> dict:
    """A contact of random formulation, stiffness, friction and form."""
    sides = [bodies[place.split(".")[0]]["backend"] for place in (a, b)]
    full = not bonded and draw.chance(0.15)
    contact = {"a": a, "b": b, "form": draw.choice(["penalty", "saddle"])}
    contact["formulation"] = _formulation(draw, sides if full else sides[:1], bonded)
    if contact["formulation"].get("lumped"):
        contact["form"] = "penalty"
    if full:
        contact["full_pass"] = True
    name, value = _stiffness(draw, contact["form"], width)
    contact[name] = value
    if draw.has_friction and not bonded:
        contact["mu"] = _friction(draw)
        contact["friction_direction_on_a"] = {"vector": [draw.choice([1.0, -1.0]), 0.0]}
    return contact


def _formulation(draw: Draw, backends: list[str], bonded: bool) -> dict:
    if bonded:
        return {"method": "bonded"}
    names = [
        name
        for name, kind in registered().items()
        if name != "bonded" and all(suits(kind, backend) for backend in backends)
    ]
    weights = [3.0 if name in ("mortar", "gpts") else 1.0 for name in names]
    formulation = {"method": draw.choice(names, weights=weights)}
    match formulation["method"]:
        case "gpts":
            formulation["points"] = int(draw.rng.integers(1, 6))
            if draw.chance(0.25):
                formulation["lumped"] = True
        case "grid":
            formulation["points"] = int(draw.rng.integers(2, 9))
        case "greville" | "botella":
            formulation["weights"] = draw.choice(["equal", "area"])
        case "node_to_surface":
            formulation["weights"] = draw.choice(["equal", "tributary"])
    return formulation


def _stiffness(draw: Draw, form: str, width: float) -> tuple[str, float | str]:
    """P or p, mostly near that of the bodies; infinite now and then in the saddle form."""
    if form == "saddle" and draw.chance(0.15):
        return draw.choice(["P", "p"]), float("inf")
    low, high = draw.choice([(1e-1, 1e5), (1e-4, 1e14)], weights=[0.6, 0.4])
    P = draw.modulus * draw.log(low, high)
    if draw.chance(0.4):
        return "P", P
    p = float(f"{P / width:.6g}")
    if draw.chance(0.15):
        jump = draw.log(1e-6, 1e6)
        return "p", f"where(x < {draw.between(-0.2, 0.2) * width}, {p}, {p * jump})"
    return "p", p


def _friction(draw: Draw) -> float | str:
    mu = draw.log(*draw.choice([(1e-2, 5.0), (0.5, 5.0)]))
    return draw.choice(
        [0.0, 1e-12, mu, f"{mu}*(1 + sin({draw.between(1.0, 30.0)}*x))", f"{mu}*abs(cos(7*x/3))"],
        weights=[0.08, 0.06, 0.7, 0.08, 0.08],
    )


def supports(draw: Draw, far: str, sides: list[str], *, free: float) -> dict:
    """Supports of a body by chance: none, its far face, rollers, a side, springs."""
    if draw.chance(free):
        return {}
    stiffness = draw.modulus / draw.length * draw.log(1e-3, 1e3)
    foundation = [stiffness, draw.log(0.1, 10) * stiffness]
    origin = [draw.between(-1, 1) * draw.length, draw.length]
    return draw.choice(
        [
            {"supports": [{"surface": far}]},
            {"supports": [{"surface": draw.choice(sides)}]},
            {"supports": [{"surface": far, "components": ["normal"]}]},
            {"supports": [{"surface": far}, {"surface": sides[0], "components": ["x"]}]},
            {"supports": [{"surface": far, "components": ["radial"], "origin": origin}]},
            {"springs": [{"surface": far, "stiffness": foundation}]},
        ],
        weights=[0.5, 0.1, 0.1, 0.1, 0.1, 0.1],
    )


def rectangle(x: float, y: float, width: float, height: float) -> dict:
    return {"shape": "rectangle", "size": [width, height], "origin": [x, y]}


def leaning(x: float, y: float, width: float, height: float, lean: float) -> dict:
    """A parallelogram whose head stands beside its foot."""
    corners = [[x, y], [x + lean, y + height], [x + width, y], [x + width + lean, y + height]]
    return {
        "shape": "patches",
        "patches": [
            {
                "degrees": [1, 1],
                "knots": [[0, 0, 1, 1], [0, 0, 1, 1]],
                "control_points": [corners[:2], corners[2:]],
            }
        ],
        "faces": {
            "y_min": [[0, 1, 0]],
            "y_max": [[0, 1, 1]],
            "x_min": [[0, 0, 0]],
            "x_max": [[0, 0, 1]],
        },
    }


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
