"""Geometry: elements and bodies far longer than wide, edges, corners, sides that do not touch."""

from functools import partial
from math import inf
from typing import Any

import numpy as np
from scipy.linalg import eigvals
from scipy.special import roots_legendre

from comparisons.stability.parts.case import (
    ACCURATE,
    HONEST,
    MESH,
    NOT_ACCURATE,
    WARNED,
    Case,
    Rows,
    refused,
)
from comparisons.stability.parts.mesh_files import OfMeshFile
from comparisons.stability.parts.references import benign, formula
from comparisons.stability.parts.scenes import (
    ABOUT_Z,
    HELD_ABOVE,
    HELD_BELOW,
    Scene,
    body,
    changed,
    contact,
    layers,
    moved,
    pad,
    patch,
    rectangle,
    scene,
    up_to,
)
from comparisons.stability.parts.ways import ALONE, FEW, MORTAR, PAIR, WAYS, chosen, without

SUBJECT = "geometry"
_FE = chosen(PAIR, backend="fe")
_HALF_PASS = without(WAYS, "full pass")

_EDGES = {
    "edges inside elements": (0.5, 0.63, (3, 2)),
    "on one element": (0.1, 0.85, (3, 2)),
    "one element on one": (0.1, 0.85, (1, 1)),
    "edge on an edge": (0.4, 0.8, (2, 2)),
    "edge almost on an edge": (0.4, 0.8 - 1e-13, (2, 2)),
}
"""Width of the pad, x of its left edge, its elements; those of the base end at 0.4, 0.8, ..."""


def _long(width: float, height: float) -> Scene:
    below = rectangle((width, height), (0.0, -height))
    return scene(
        {
            "upper": body(rectangle((width, height)), (2, 2), E=0.5, supports=HELD_ABOVE),
            "lower": body(below, (3, 2), supports=HELD_BELOW),
        },
        contact=contact("upper.y_min", "lower.y_max"),
    )


def _sectors(degrees: float) -> Scene:
    """One sector round another."""

    def sector(inner: float, outer: float, held: str) -> Scene:
        radii = {"inner_radius": inner, "outer_radius": outer}
        geometry = {"shape": "ring_sector", **radii, "start": 30.0, "end": 30.0 + degrees}
        return body(geometry, (2, 3 if held == "outer" else 2), supports=[{"surface": held}])

    sliding = contact("outer.inner", "inner.outer", friction_direction_on_a=ABOUT_Z)
    return scene(
        {"outer": sector(1.0, 1.5, "outer"), "inner": sector(0.5, 1.0, "inner")}, contact=sliding
    )


def _crowned(radius: float) -> Scene:
    """The pad with its face crowned, on its base."""
    flat = pad(0.5)
    face = {"base": flat["bodies"]["pad"]["geometry"], "surface": "y_min", "radii": {"x": radius}}
    return changed(flat, {"bodies.pad.geometry": {"shape": "crowned", **face}})


def _nearly_flat(radius: float) -> Rows:
    fall = 0.5**2 / (8 * radius) / 0.4  # of the face, relative to the height of the pad
    return Rows(
        {f"radius {radius:.0e}": _crowned(radius)},
        instead=pad(0.5),
        tolerance=max(1e-8, 10 * fall if fall > 1e-10 else 0.0),
    )


_LEAVES_THE_SIDE = _crowned(0.5)
_CLOSED = changed(_LEAVES_THE_SIDE, {"contacts.contact.reach": 0.3})


_OVERHANG = chosen(
    WAYS, "node", "Greville", "GPTS, penalty", "segments, penalty", "mortar, penalty"
)


def _apart(distance: float) -> Rows:
    """In truth the sides do not touch."""
    data = changed(pad(1.0), {"bodies.pad.geometry.origin": [0.5, distance]})
    return Rows(
        {f"{distance:g} m apart": data},
        chosen(WAYS, "node", "Greville", "GPTS, penalty", "segments, penalty", "mortar"),
        instead=data | {"contacts": {}},
        expected=NOT_ACCURATE,
    )


def _crowded(number: int, **options: Any) -> Scene:
    """Layers of cells towards an edge of the face that is held and one of the face that slides."""
    edges = [{"x": 0.0, "y": -1.0}, {"x": 2.0, "y": 0.0}]
    data = layers(**options)
    data["bodies"]["lower"]["mesh"]["fe"].update({"edges": edges, "layers": number})
    return data


_BENDING = np.array([1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349, 14.1371683910])
"""beta L of a cantilever: cos x cosh x = -1."""


def _strip(slenderness: float) -> Rows:
    """A cantilever of length 2 in plane strain, E = rho = 1, beside Euler and Bernoulli.

    Half as many elements lock: cubic splines are then off by 2 percent in the fourth mode, which is
    an error of the mesh that no run tells.
    """
    height = 2.0 / slenderness
    held = [{"surface": "x_min"}]
    strip = body(rectangle((2.0, height)), (40, 1), degree=3, nu=0.3, supports=held)
    omega = (_BENDING / 2.0) ** 2 * height / np.sqrt(12 * (1 - 0.3**2))
    expected = ACCURATE if slenderness < 1e3 else HONEST
    true = formula([1j * value for value in omega])
    row = {f"L/h = {slenderness:.0e}": scene({"strip": strip})}
    return Rows(row, ALONE, true, expected=expected, tolerance=5e-3, lowest=3)


_MU = 0.3
_RIGID = 1e7
"""E at which bodies are rigid beside a contact of p = 1 N/m^3."""


def _push(a: str, b: str, direction: tuple[float, float], p: float) -> Scene:
    return contact(a, b, p=p, mu=_MU, friction_direction_on_a={"vector": list(direction)})


def _corner(p: float, *, together: bool = True, E: float = 1.0) -> Scene:
    """A block in the corner of a seat, one contact over both faces or one for each."""
    block = patch([[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]])
    below, left = [[0, 1, 0]], [[0, 0, 0]]
    block["faces"] = {"below": below, "left": left, "corner": below + left}
    seat = patch([[-0.5, -0.5], [0.0, -0.5]], [[-0.5, 0.0], [0.0, 0.0]])
    for low, high in (((0.0, -0.5), (1.5, 0.0)), ((-0.5, 0.0), (0.0, 1.5))):
        part = patch([[low[0], low[1]], [high[0], low[1]]], [[low[0], high[1]], [high[0], high[1]]])
        seat["patches"] += part["patches"]
    floor, wall = [[1, 1, 1]], [[2, 0, 1]]
    foot = [[0, 1, 0], [1, 1, 0]]
    seat["faces"] = {"base": foot, "floor": floor, "wall": wall, "corner": floor + wall}
    bodies = {
        "block": body(block, (4, 4), E=E),
        "seat": body(seat, (3, 3), E=E, supports=[{"surface": "base"}]),
    }
    if together:
        return scene(bodies, contact=_push("block.corner", "seat.corner", (1.0, 1.0), p))
    return scene(
        bodies,
        floor=_push("block.below", "seat.floor", (1.0, 0.0), p),
        wall=_push("block.left", "seat.wall", (0.0, 1.0), p),
    )


def _corner_of_rectangles() -> Scene:
    """Both bodies rigid and as rectangles, which become a block and a seat in a mesh file."""
    seat = rectangle((2.0, 2.0), (-0.5, -0.5))
    return scene(
        {
            "block": body(rectangle((1.0, 1.0)), (4, 4), E=_RIGID),
            "seat": body(seat, (8, 8), E=_RIGID, supports=HELD_BELOW),
        },
        contact=_push("block.corner", "seat.corner", (1.0, 1.0), 1.0),
    )


def _rigid_block() -> list[complex]:
    """Lambda (1/s) of a rigid unit block in a rigid seat, rho = 1, p = 1, about its corner.

    Of motions m the gap is n.m and the slip k.m; both faces add p (n.m_i + mu k.m_i) (n.m_j).
    """
    stiffness = np.zeros((3, 3))
    for s, w in zip(*roots_legendre(3), strict=True):
        along, weight = (1 + s) / 2, w / 2
        for position, closed, slid in (
            (np.array([along, 0.0]), np.array([0.0, -1.0]), np.array([1.0, 0.0])),
            (np.array([0.0, along]), np.array([-1.0, 0.0]), np.array([0.0, 1.0])),
        ):
            turned = np.array([-position[1], position[0]])
            gap, slip = (np.append(each, each @ turned) for each in (closed, slid))
            stiffness += weight * np.outer(gap - _MU * slip, gap)
    centre = 0.5
    mass = np.array([[1.0, 0.0, -centre], [0.0, 1.0, centre], [-centre, centre, 2 / 3]])
    values = 1j * np.sqrt(eigvals(stiffness, mass).astype(complex))
    return [complex(value) for value in values]


_IN_CORNER = chosen(WAYS, "segments", "mortar", "GPTS, penalty", "GPTS, saddle")
_NOTCHED = partial(
    OfMeshFile,
    notches={"seat": (0.0, 0.0)},
    surfaces={"corner": {"block": ("x_min", "y_min"), "seat": ("notch",)}},
)

_FILES: dict[str, tuple[Scene, dict[str, Any]]] = {
    "metres": (layers(), {}),
    "micrometres": (layers(), {"unit": "um"}),
    "feet": (layers(), {"unit": "ft"}),
    "elements of aspect 1e4": (layers(height=1e-4), {}),
    "node numbers to 1e9": (layers(), {"numbers": 10**7}),
    "a pad that ends on its base": (pad(), {"unit": "mm"}),
}
_BAD_FILES: dict[str, tuple[dict[str, Any], str]] = {
    "no unit": ({"unit": None}, "unit"),
    "two bodies as one": ({"part": None}, "part"),
    "a set that is not there": ({"faces": {"y_min": "nowhere"}}, "faces"),
}


def _refused_file(row: str) -> Rows:
    change, names = _BAD_FILES[row]
    rows = refused({row: layers()}, _FE, names)
    rows.problem = partial(OfMeshFile, geometry=change)
    return rows


CASES = {
    "apart": Case("Sides of a contact 0.1 to 0.24 m apart", *(_apart(d) for d in (0.1, 0.24))),
    "aspect": Case(
        "Elements 1e3 times longer than wide, both ways",
        Rows({"flat elements": _long(1e3, 1.0)}, FEW),
        Rows({"columns": _long(1.0, 1e3)}, FEW, expected=WARNED, tolerance=1e-4),
    ),
    "contact_corner": Case(
        "A contact whose surfaces turn a corner",
        Rows(
            {"rigid bodies": up_to(1.0, _corner_of_rectangles())},
            chosen(_IN_CORNER, backend="fe"),
            formula(_rigid_block()),
            problem=_NOTCHED,
            tolerance=1e-6,
        ),
        Rows(
            {"rigid bodies": up_to(1.0, _corner(1.0, E=_RIGID))},
            chosen(_IN_CORNER, backend="iga"),
            formula(_rigid_block()),
            tolerance=1e-6,
        ),
        Rows(
            {"as a contact for each face": _corner(1.0)},
            chosen(WAYS, backend="iga"),
            instead=_corner(1.0, together=False),
        ),
        Rows(
            {"tied, as a tie for each face": _corner(inf)},
            chosen(MORTAR, "mortar, saddle", backend="iga"),
            instead=_corner(inf, together=False),
        ),
    ),
    "contact_edges": Case(
        "Edges of the contact inside elements, contact on one element",
        Rows(
            {name: pad(width, at, pad_elements=n) for name, (width, at, n) in _EDGES.items()},
            _HALF_PASS,
        ),
    ),
    "crowned": Case(
        "A crowned face, its radius of curvature from 0.05 to 1e30",
        *(_nearly_flat(radius) for radius in (1e4, 1e6, 1e8, 1e12, 1e30)),
        Rows(
            {"radius 0.5, closed": _CLOSED},
            _OVERHANG,
            instead=_CLOSED | {"contacts": {}},
            expected=NOT_ACCURATE,
        ),
        refused(
            {"radius 0.05": _crowned(0.05)},
            _OVERHANG,
            "radii",
        ),
    ),
    "edge_layers": Case(
        "Layers of cells towards edges",
        Rows(
            {
                f"{n} layer{'s' if n > 1 else ''}, degree {degree}": _crowded(
                    n, lower={"degree": degree}
                )
                for degree in (1, 2, 4)
                for n in (1, 4, 8)
            },
            _FE,
        ),
        refused(
            {"edges at opposite corners of a cell": _crowded(1, lower_elements=(1, 1))},
            _FE,
            "elements",
        ),
    ),
    "far_origin": Case(
        "The origin 1e3 and 1e6 m away",
        *(
            Rows(
                {f"{name} {away:.0e} m away": moved(data, (away, -away))},
                true=benign,
                instead=data,
                tolerance=tolerance,
            )
            for away, tolerance in ((1e3, 1e-9), (1e6, 1e-6))
            for name, data in (("layers", layers()), ("pad", pad(max_missed=0.6)))
        ),
    ),
    "mesh_files": Case(
        "Bodies from mesh files",
        *(
            Rows({row: data}, _FE, problem=partial(OfMeshFile, **options))
            for row, (data, options) in _FILES.items()
        ),
        *(_refused_file(row) for row in _BAD_FILES),
    ),
    "mesh_ratio": Case(
        "Mesh ratio 1 to 50 across the contact, both ways",
        Rows(
            {
                row: layers(upper_elements=(upper, 1), lower_elements=(lower, 1))
                for row, upper, lower in (
                    ("1 element on 50", 1, 50),
                    ("50 elements on 1", 50, 1),
                )
            }
        ),
    ),
    "narrow_sector": Case(
        "Sectors of 90 to 0.1 degrees",
        Rows({f"{degrees:g} degrees": _sectors(degrees) for degrees in (90.0, 1.0)}, FEW),
        Rows({"0.1 degrees": _sectors(0.1)}, FEW, expected=WARNED, tolerance=1e-6),
    ),
    "overhang": Case(
        "A pad over the edge of its base",
        refused(
            {"half of it, not allowed": pad(0.5, 1.75)},
            chosen(_HALF_PASS, "node", "Greville", "GPTS", "segments", "mortar"),
            "contact",
        ),
        Rows(
            {"half of it, allowed": pad(0.5, 1.75, max_missed=0.6)},
            chosen(_HALF_PASS, "node", "Greville", "GPTS", "segments", "mortar"),
            warnings=(*MESH, "partly-uncovered"),
        ),
    ),
    "thin_layer": Case(
        "A layer in contact, thickness 1e-3 to 1e-5 of its length",
        Rows(
            {
                f"thickness {height / 2:.0e} of the length": layers(height=height)
                for height in (2e-3, 2e-4, 2e-5)
            },
            FEW,
            tolerance=1e-7,
        ),
    ),
    "thin_strip": Case(
        "Thin cantilevers, length over height 100 to 1e5",
        *(_strip(slenderness) for slenderness in (1e2, 1e3, 2e4, 1e5)),
    ),
}
