"""A mass between four walls: the model of Hulten made of elastic bodies.

A stiff square of mass 1 slides past a wall on each of its sides, the friction of the walls going
round it. Penalties hold it with k1 along x and k2 along y. Opposite walls share each, so that
neither their forces nor their friction turns the square; what is left are two degrees of freedom,

    x'' + c1 x' + k1 x - mu k2 y = 0,     y'' + c2 y' + mu k1 x + k2 y = 0

up to terms of the order k / E. c1 = alpha damps the whole mass; c2 is more than that by friction
that rises with the speed on the walls across x, along which they are slid on.
"""

from typing import Any

from scenes.spec.body import Backend

K1, K2 = 1.0, 1.44
"""Stiffness along x and y (N/m)."""
MODULUS = 1e6
"""Young's modulus of all bodies (N/m^2)."""
TOP = 0.3
"""Upper end of the modes (Hz), above both of the mass, which are at 0.16 and 0.19."""

_DEEP = 0.2
"""Depth of the walls (m)."""
_WALLS = {
    "left": ("x_min", "x_max", (-_DEEP, 0.0), (_DEEP, 1.0), (0.0, 1.0), K1),
    "right": ("x_max", "x_min", (1.0, 0.0), (_DEEP, 1.0), (0.0, -1.0), K1),
    "lower": ("y_min", "y_max", (0.0, -_DEEP), (1.0, _DEEP), (-1.0, 0.0), K2),
    "upper": ("y_max", "y_min", (0.0, 1.0), (1.0, _DEEP), (1.0, 0.0), K2),
}
"""Sides of the square and of the wall, corner and size of the wall, direction of friction on the
square, stiffness along the normal of both walls together."""
_ACROSS_X = ("left", "right")
_OPPOSITE = {"x_min": "x_max", "x_max": "x_min", "y_min": "y_max", "y_max": "y_min"}


def hulten_scene(backend: Backend, c1: float, c2: float) -> dict[str, Any]:
    """The scene as plain data, without friction.

    Parameters
    ----------
    backend
        Backend of every body.
    c1, c2
        Damping along x and y (N s/m), c2 not below c1.
    """
    square = _body(backend, (0.0, 0.0), (1.0, 1.0))
    if c1:
        square["damping"] = {"alpha": c1}
    bodies, contacts = {"square": square}, {}
    for name, (of_square, of_wall, corner, size, direction, k) in _WALLS.items():
        wall = _body(backend, corner, size)
        wall["supports"] = [{"surface": _OPPOSITE[of_wall]}]
        bodies[name] = wall
        contacts[name] = {
            "a": f"square.{of_square}",
            "b": f"{name}.{of_wall}",
            "formulation": {"method": "gpts", "points": 3},
            "P": 0.5 * k,
            "form": "penalty",
            "friction_direction_on_a": {"vector": list(direction)},
        }
        if name in _ACROSS_X and c2 > c1:
            contacts[name]["sliding"] = {"pressure": 1.0, "mu_slope": 0.5 * (c2 - c1)}
    return {
        "name": "mass between four walls",
        "bodies": bodies,
        "contacts": contacts,
        "analysis": {"kind": "cea", "max_frequency": TOP},
    }


def _body(backend: Backend, corner: tuple[float, ...], size: tuple[float, ...]) -> dict[str, Any]:
    """A stiff rectangle of one element; the mass of the square is 1 kg."""
    return {
        "backend": backend,
        "geometry": {"shape": "rectangle", "origin": list(corner), "size": list(size)},
        "material": {"E": MODULUS, "nu": 0.3, "rho": 1.0},
        "mesh": {
            "fe": {"cell": "quadrilateral", "degree": 2, "elements": [1, 1]},
            "iga": {"degree": [2, 2], "elements": [1, 1]},
        },
    }
