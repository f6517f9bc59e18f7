"""Pieces of random scenes: bodies with meshes and supports, contacts with all that they say."""

import numpy as np

from cea.contact.formulations import registered
from scenes.spec.contact import suits

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
