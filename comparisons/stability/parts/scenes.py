"""Small scenes as plain data, which cases make extreme."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

Scene = dict[str, Any]

_LENGTHS = ("size", "origin")
"""Fields of rectangles that are lengths."""


def body(
    geometry: Mapping[str, Any],
    elements: Sequence[int],
    *,
    degree: int = 2,
    E: float = 1.0,
    nu: float = 0.3,
    rho: float = 1.0,
    supports: Sequence[Mapping[str, Any]] = (),
    **others: Any,
) -> Scene:
    """A body on both backends, or on NURBS alone where its geometry is one of patches.

    Parameters
    ----------
    geometry
        Its shape.
    elements
        Elements along each direction, on both backends.
    degree
        Degree on both backends; Lagrange elements go to 4.
    E, nu, rho
        Material.
    supports
        Its supports.
    others
        Other fields of a body, e.g. placement.
    """
    dim = len(elements)
    cell = {2: "quadrilateral", 3: "hexahedron"}[dim]
    mesh: Scene = {"iga": {"degree": [degree] * dim, "elements": list(elements)}}
    if geometry["shape"] != "patches" and degree <= 4:
        mesh["fe"] = {"cell": cell, "degree": degree, "elements": list(elements)}
    return {
        "backend": "iga",
        "geometry": dict(geometry),
        "material": {"E": E, "nu": nu, "rho": rho},
        "supports": [dict(support) for support in supports],
        "mesh": mesh,
        **others,
    }


def rectangle(size: Sequence[float], origin: Sequence[float] = (0.0, 0.0)) -> Scene:
    """A rectangle as geometry."""
    return {"shape": "rectangle", "size": list(size), "origin": list(origin)}


def patch(bottom: Sequence[Sequence[float]], top: Sequence[Sequence[float]]) -> Scene:
    """A quadrilateral patch, v from bottom to top, u along both; faces foot and, if any, head.

    Parameters
    ----------
    bottom, top
        Its two corners there.
    """
    points = [[list(low), list(high)] for low, high in zip(bottom, top, strict=True)]
    return patches(points)


def patches(points: Any, weights: Any = None, **fields: Any) -> Scene:
    """One patch of linear splines, or of what the fields say; faces foot and head.

    Parameters
    ----------
    points, weights
        Control points, weights; all 1 by default.
    fields
        Other fields of a patch: degrees, knots.
    """
    given = {"degrees": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "control_points": points}
    given |= fields | ({} if weights is None else {"weights": weights})
    faces = {"foot": [[0, 1, 0]]}
    if any(column[-1] != points[0][-1] for column in points):  # a pole is no face
        faces["head"] = [[0, 1, 1]]
    return {"shape": "patches", "patches": [given], "faces": faces}


def contact(a: str, b: str, **fields: Any) -> Scene:
    """A contact with friction along x; mortar until a way says else."""
    base = {
        "a": a,
        "b": b,
        "formulation": {"method": "mortar"},
        "mu": 0.3,
        "friction_direction_on_a": {"vector": [1.0, 0.0]},
    }
    stiffness = {} if "P" in fields or "p" in fields else {"p": 1.0}
    return base | stiffness | fields


def scene(
    bodies: Mapping[str, Any], analysis: Mapping[str, Any] | None = None, **contacts: Any
) -> Scene:
    """Bodies and contacts whose modes are asked for, up to a frequency that the reference says."""
    return {
        "name": "stability",
        "bodies": dict(bodies),
        "contacts": contacts,
        "analysis": dict(analysis or {"kind": "cea"}),
    }


def layers(
    *,
    upper: Mapping[str, Any] | None = None,
    lower: Mapping[str, Any] | None = None,
    upper_elements: Sequence[int] = (5, 2),
    lower_elements: Sequence[int] = (4, 3),
    height: float = 0.5,
    **fields: Any,
) -> Scene:
    """Two layers between rollers, one sliding on the other: the problem `blocks`, on few elements.

    Parameters
    ----------
    upper, lower
        Fields of :func:`body` that differ: degree, E, nu, rho.
    upper_elements, lower_elements
        Elements along x and y.
    height
        Height of the upper layer.
    fields
        Fields of the contact.
    """

    def walls(held: str) -> list[Scene]:
        return [
            {"surface": held},
            *({"surface": f"x_{end}", "components": ["x"]} for end in ("min", "max")),
        ]

    return scene(
        {
            "upper": body(
                rectangle((2.0, height)),
                upper_elements,
                **{"E": 0.1, "nu": 0.25, "rho": 0.35, "supports": walls("y_max"), **(upper or {})},
            ),
            "lower": body(
                rectangle((2.0, 1.0), (0.0, -1.0)),
                lower_elements,
                **{"supports": walls("y_min"), **(lower or {})},
            ),
        },
        interface=contact("upper.y_min", "lower.y_max", **fields),
    )


def pad(
    width: float = 0.5,
    at: float = 0.75,
    *,
    pad_elements: Sequence[int] = (3, 2),
    base_elements: Sequence[int] = (5, 3),
    **fields: Any,
) -> Scene:
    """A pad that is held at its back, on a wider base.

    Parameters
    ----------
    width, at
        Width of the pad, and x of its left edge; the base reaches from 0 to 2.
    pad_elements, base_elements
        Elements along x and y.
    fields
        Fields of the contact.
    """
    return scene(
        {
            "pad": body(
                rectangle((width, 0.4), (at, 0.0)),
                pad_elements,
                E=0.5,
                supports=[{"surface": "y_max"}],
            ),
            "base": body(
                rectangle((2.0, 1.0), (0.0, -1.0)), base_elements, supports=[{"surface": "y_min"}]
            ),
        },
        contact=contact("pad.y_min", "base.y_max", **fields),
    )


def sprag(angle: float = 60.0, mu: float = 0.3, **fields: Any) -> Scene:
    """A block whose back slides obliquely to its contact: with mu above cot(angle) it diverges.

    Both bodies stand turned by an angle about z; the back of the block is held along x alone. It
    moves along y, at cos(angle) to the normal of the contact, and friction takes away
    mu sin(angle) of what the contact gives back.

    Parameters
    ----------
    angle
        Angle (degrees).
    mu
        Friction coefficient.
    fields
        Fields of the contact.
    """
    turned = {"angle": angle}
    slope = {"field": [f"-cos({angle}*pi/180)", f"-sin({angle}*pi/180)"]}
    return scene(
        {
            "block": body(
                rectangle((1.0, 0.5)),
                (3, 2),
                supports=[{"surface": "y_max", "components": ["x"]}],
                placement=turned,
            ),
            "base": body(
                rectangle((2.0, 1.0), (-0.5, -1.0)),
                (5, 2),
                supports=[{"surface": "y_min"}],
                placement=turned,
            ),
        },
        contact=contact(
            "block.y_min", "base.y_max", **{"mu": mu, "friction_direction_on_a": slope, **fields}
        ),
    )


def changed(data: Mapping[str, Any], changes: Mapping[str, Any]) -> Scene:
    """A scene with fields changed by their paths, as ``contacts.interface.mu``."""
    copy = deepcopy(dict(data))
    for path, value in changes.items():
        *parents, last = path.split(".")
        table = copy
        for name in parents:
            table = table.setdefault(name, {})
        table[last] = value
    return copy


def in_units(data: Mapping[str, Any], *, metre: float = 1.0, kilogram: float = 1.0) -> Scene:
    """A scene of rectangles in other units of length and mass, with p given; the second stays.

    Parameters
    ----------
    data
        The scene in m, kg, s.
    metre, kilogram
        One metre, one kilogram in the new units.
    """
    copy = deepcopy(dict(data))
    for each in copy["bodies"].values():
        geometry = each["geometry"]
        for name in set(_LENGTHS) & set(geometry):
            geometry[name] = [length * metre for length in geometry[name]]
        each["material"]["E"] *= kilogram / metre
        each["material"]["rho"] *= kilogram / metre**3
    for each in copy["contacts"].values():
        each["p"] *= kilogram / metre**2
    return copy | {"units": "other"}


def moved(data: Mapping[str, Any], shift: Sequence[float]) -> Scene:
    """A scene of rectangles with its origin elsewhere (m)."""
    copy = deepcopy(dict(data))
    for each in copy["bodies"].values():
        origin = each["geometry"]["origin"]
        each["geometry"]["origin"] = [o + s for o, s in zip(origin, shift, strict=True)]
    return copy
