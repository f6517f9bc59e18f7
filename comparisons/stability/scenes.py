"""Small scenes as plain data, which cases make extreme."""

from collections.abc import Mapping, Sequence
from typing import Any

from scenes.spec.plain import changed as changed
from scenes.spec.plain import plain_data, tables_of

Scene = dict[str, Any]

STEEL = {"E": 2.1e11, "nu": 0.3, "rho": 7800.0}
LINING = {"E": 8e9, "nu": 0.3, "rho": 2500.0}
WALLS = [{"surface": f"x_{end}", "components": ["x"]} for end in ("min", "max")]
"""Rollers at both ends."""
ROLLER = {"surface": "y_max", "components": ["x"]}
"""A roller that lets the upper face move along y."""
FINE: Scene = {"upper_elements": (8, 3), "lower_elements": (7, 4)}
"""Elements of finer layers."""
ABOUT_Z = {"circumferential_about": [0.0, 0.0, 1.0]}


def body(
    geometry: Mapping[str, Any],
    elements: Sequence[int],
    *,
    degree: int = 2,
    E: float = 1.0,
    nu: float = 0.3,
    rho: float = 1.0,
    held: str = "",
    supports: Sequence[Mapping[str, Any]] = (),
    **others: Any,
) -> Scene:
    """A body for both backends; for NURBS alone if it is made of patches or of degree above 4."""
    mesh = meshes(elements, degree)
    if geometry["shape"] == "patches" or degree > 4:
        del mesh["fe"]
    return {
        "backend": "iga",
        "geometry": dict(geometry),
        "material": {"E": E, "nu": nu, "rho": rho},
        "supports": [*([{"surface": held}] if held else []), *map(dict, supports)],
        "mesh": mesh,
        **others,
    }


def meshes(elements: Sequence[int], degree: int) -> Scene:
    """Meshes of both backends between the same breaks."""
    cell = {2: "quadrilateral", 3: "hexahedron"}[len(elements)]
    return {
        "fe": {"cell": cell, "degree": degree, "elements": list(elements)},
        "iga": {"degree": [degree] * len(elements), "elements": list(elements)},
    }


def coarse(name: str, degree: int, **elements: Sequence[int]) -> Scene:
    """A scene of the catalogue on coarse meshes; the reference sets the end of its window."""
    data = tables_of(name) | {"analysis": {"kind": "cea"}}
    for body, counts in elements.items():
        data["bodies"][body]["mesh"] = meshes(counts, degree)
    return data


def rectangle(size: Sequence[float], origin: Sequence[float] = (0.0, 0.0)) -> Scene:
    """A rectangle as geometry."""
    return {"shape": "rectangle", "size": list(size), "origin": list(origin)}


def ring(inner: float, outer: float) -> Scene:
    """A ring as geometry."""
    return {"shape": "ring", "inner_radius": inner, "outer_radius": outer}


def base(elements: Sequence[int] = (5, 3), **fields: Any) -> Scene:
    """The body below a pad: 2 wide, 1 high, held at its foot, its top at y = 0."""
    ground = {"held": "y_min", **fields}
    return body(rectangle((2.0, 1.0), (0.0, -1.0)), elements, **ground)


def patch(bottom: Sequence[Sequence[float]], top: Sequence[Sequence[float]]) -> Scene:
    """A quadrilateral patch between the corners of its bottom and its top: faces foot, head."""
    return spline_patch([[list(low), list(high)] for low, high in zip(bottom, top, strict=True)])


def spline_patch(points: Any, weights: Any = None, **fields: Any) -> Scene:
    """One patch of linear splines, or with other degrees and knots; faces foot and head."""
    given = {"degrees": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "control_points": points}
    given |= fields | ({} if weights is None else {"weights": weights})
    faces = {"foot": [[0, 1, 0]]}
    if any(column[-1] != points[0][-1] for column in points):  # a pole is no face
        faces["head"] = [[0, 1, 1]]
    return {"shape": "patches", "patches": [given], "faces": faces}


def contact(a: str, b: str, **fields: Any) -> Scene:
    """A contact with friction along x; mortar until a way changes it."""
    return {
        "a": a,
        "b": b,
        "formulation": {"method": "mortar"},
        "mu": 0.3,
        "friction_direction_on_a": {"vector": [1.0, 0.0]},
        **({} if {"P", "p", "c_n"} & fields.keys() else {"p": 1.0}),
        **fields,
    }


def scene(
    bodies: Mapping[str, Any], analysis: Mapping[str, Any] | None = None, **contacts: Any
) -> Scene:
    """A scene of bodies and contacts; the reference sets the end of its window."""
    return {
        "name": "stability",
        "bodies": dict(bodies),
        "contacts": contacts,
        "analysis": dict(analysis or {"kind": "cea"}),
    }


def stacked(
    upper: Mapping[str, Any], lower: Mapping[str, Any], kind: str = "cea", **fields: Any
) -> Scene:
    """A body that slides on another, in contact along x."""
    sliding = contact("upper.y_min", "lower.y_max", **fields)
    return scene({"upper": upper, "lower": lower}, {"kind": kind}, contact=sliding)


def layers(
    *,
    both: Mapping[str, Any] | None = None,
    upper: Mapping[str, Any] | None = None,
    lower: Mapping[str, Any] | None = None,
    upper_elements: Sequence[int] = (5, 2),
    lower_elements: Sequence[int] = (4, 3),
    height: float = 0.5,
    **fields: Any,
) -> Scene:
    """Two layers between rollers, one sliding on the other: the problem `blocks`, coarse.

    ``upper`` (and its height), ``lower`` and ``both`` change fields of :func:`body`, ``fields``
    the contact.
    """
    same = {"supports": WALLS} | dict(both or {})
    soft: Scene = {"E": 0.1, "nu": 0.25, "rho": 0.35, "held": "y_max"} | same | dict(upper or {})
    bodies = {
        "upper": body(rectangle((2.0, height)), upper_elements, **soft),
        "lower": base(lower_elements, **same | dict(lower or {})),
    }
    return scene(bodies, interface=contact("upper.y_min", "lower.y_max", **fields))


def pad(
    width: float = 0.5, at: float = 0.75, *, pad_elements: Any = (3, 2), **fields: Any
) -> Scene:
    """A pad, its left edge at x = ``at`` and held at its back, on a base from x = 0 to 2."""
    upper = body(rectangle((width, 0.4), (at, 0.0)), pad_elements, E=0.5, held="y_max")
    sliding = contact("pad.y_min", "base.y_max", **fields)
    return scene({"pad": upper, "base": base()}, contact=sliding)


def on_base(geometry: Mapping[str, Any], *, held: bool = True) -> Scene:
    """A NURBS body with the faces foot and head, on a base."""
    upper = body(geometry, (3, 2), held="head" if held else "")
    return scene({"pad": upper, "base": base()}, contact=contact("pad.foot", "base.y_max"))


def boxes(
    upper: tuple[Sequence[float], Sequence[int]],
    lower: tuple[Sequence[float], Sequence[int]],
    *,
    at: tuple[float, float] = (0.0, 0.0),
    E: float = 1.0,
    held: bool = True,
    **fields: Any,
) -> Scene:
    """Two boxes on each other by size and elements, the upper one at x, y and of modulus E."""
    top, bottom = ("z_max", "z_min") if held else ("", "")
    above = {"shape": "box", "size": list(upper[0]), "origin": [*at, 0.0]}
    below = {"shape": "box", "size": list(lower[0]), "origin": [0.0, 0.0, -lower[0][2]]}
    parts = {
        "upper": body(above, upper[1], E=E, held=top),
        "lower": body(below, lower[1], held=bottom),
    }
    along = {"friction_direction_on_a": {"vector": [1.0, 0.0, 0.0]}}
    return scene(parts, contact=contact("upper.z_min", "lower.z_max", **(along | fields)))


def unequal_boxes(**fields: Any) -> Scene:
    """A box on a longer and wider one, twice as stiff."""
    upper, lower = ((1.0, 0.8, 0.5), (2, 2, 1)), ((2.0, 1.0, 1.0), (2, 2, 1))
    return boxes(upper, lower, at=(0.3, 0.1), E=0.5, p=2.0, **fields)


def sprag(angle: float = 60.0, mu: float = 0.3, **fields: Any) -> Scene:
    """A block whose back slides obliquely to its contact: with mu above cot(angle) it diverges.

    Both bodies are turned by the angle (degrees) about z; the back of the block is held along x
    alone. It moves along y: the restoring force of the contact along it is proportional to
    cos(angle), from which friction takes mu sin(angle).
    """
    turned = {"angle": angle}
    slope = {"field": [f"-cos({angle}*pi/180)", f"-sin({angle}*pi/180)"]}
    block = body(rectangle((1.0, 0.5)), (3, 2), supports=[ROLLER], placement=turned)
    ground = body(rectangle((2.0, 1.0), (-0.5, -1.0)), (5, 2), held="y_min", placement=turned)
    fields |= {"mu": mu, "friction_direction_on_a": slope}
    sliding = contact("block.y_min", "base.y_max", **fields)
    return scene({"block": block, "base": ground}, contact=sliding)


def pressed_layers(
    pressure: float = 0.0, *, degree: int = 2, back: Mapping[str, Any] = ROLLER, **law: Any
) -> Scene:
    """Layers between rollers, pressed at their back: pressure and closure are uniform."""
    upper = {"held": "", "supports": [back, *WALLS]}
    data = layers(mu=0.0, lower_elements=(5, 3), both={"degree": degree}, upper=upper, **law)
    loads = [{"surface": "upper.y_max", "pressure": pressure}]
    return data | {"loads": loads if pressure else []}


def up_to(frequency: float, data: Mapping[str, Any]) -> Scene:
    """A scene with the end of its window (Hz)."""
    return changed(data, {"analysis.max_frequency": frequency})


def in_units(data: Mapping[str, Any], *, metre: float = 1.0, kilogram: float = 1.0) -> Scene:
    """A scene of rectangles with given p, in units of 1 / ``metre`` m and 1 / ``kilogram`` kg."""
    copy = plain_data(data)
    for each in copy["bodies"].values():
        geometry = each["geometry"]
        for name in ("size", "origin"):
            geometry[name] = [length * metre for length in geometry[name]]
        each["material"]["E"] *= kilogram / metre
        each["material"]["rho"] *= kilogram / metre**3
    for each in copy["contacts"].values():
        each["p"] *= kilogram / metre**2
    return copy | {"units": "other"}


def moved(data: Mapping[str, Any], shift: Sequence[float]) -> Scene:
    """A scene of rectangles with its origin elsewhere (m)."""
    copy = plain_data(data)
    for each in copy["bodies"].values():
        origin = each["geometry"]["origin"]
        each["geometry"]["origin"] = [o + s for o, s in zip(origin, shift, strict=True)]
    return copy
