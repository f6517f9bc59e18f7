"""Numbers that look like those of other units: a warning, never a refusal.

Any consistent units do, SI as well as mm, t and s. What is doubtful is a material whose numbers are
near to none that solids have in SI units, in a scene that is not nondimensional either.
"""

from collections.abc import Iterator
from math import sqrt

from cea.warned import ResultWarning
from scenes.spec.body import BodySpec
from scenes.spec.scene import SceneSpec

_SOFTEST = 1e3
"""E (N/m^2) below which a solid is softer than any that brakes, clutches or tyres are made of."""
_HEAVIEST = 1e6
"""rho (kg/m^3) beyond that of any matter on earth, fifty times that of platinum."""
_FASTEST = 3e4
"""Speed of sound (m/s) beyond that of any solid, twice that of diamond."""
_NEAR_ONE = (1e-3, 1e2)
"""Range of E and rho in scenes without units."""


def doubtful_units(scene: SceneSpec) -> Iterator[ResultWarning]:
    """Materials whose E or rho no solid has in SI units.

    Parameters
    ----------
    scene
        The scene; one whose every E and rho is near to one is taken as nondimensional.
    """
    if all(map(_is_near_one, scene.bodies.values())):
        return
    for name, body in scene.bodies.items():
        E, rho = body.material.E, body.material.rho
        found = {"E": E} if E < _SOFTEST else {}
        found |= {"rho": rho} if rho is not None and rho > _HEAVIEST else {}
        for field, value in found.items():
            bound = (
                f"E below {_SOFTEST:g} N/m^2" if field == "E" else f"rho over {_HEAVIEST:g} kg/m^3"
            )
            yield ResultWarning(
                "doubtful-units",
                f"bodies.{name}.material.{field} = {value:g}: no solid has {bound}; are these "
                "numbers in SI units (m, kg, s)?",
                {"body": name, "field": field, "value": value},
            )


def impossible_speeds(scene: SceneSpec) -> Iterator[ResultWarning]:
    """Bodies of files read in metres whose material has the numbers of other units."""
    for name, body in scene.bodies.items():
        E, rho = body.material.E, body.material.rho
        in_metres = getattr(body.geometry, "unit", "m") != "m"
        speed = sqrt(E / rho) if rho else 0.0
        if in_metres and speed > _FASTEST:
            yield ResultWarning(
                "doubtful-units",
                f"bodies.{name}, read in metres, has a speed of sound of {speed:.3g} m/s: no solid "
                f"has one over {_FASTEST:g}; are E and rho in N/m^2 and kg/m^3?",
                {"body": name, "field": "E / rho", "value": speed},
            )


def _is_near_one(body: BodySpec) -> bool:
    """Whether a material has numbers as scenes without units have."""
    low, high = _NEAR_ONE
    return all(low <= n <= high for n in (body.material.E, body.material.rho) if n is not None)
