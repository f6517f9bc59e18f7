"""Hertz scenes of any fineness, and how far what they give is from the closed form.

Each body is a half space under its own contact, small beside body and radius. With the load F, the
relative radius R and 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2 the pressure is
peak sqrt(1 - r^2 / a^2) within the half width or radius a (K. L. Johnson, Contact Mechanics, 1985,
sections 4.2 and 5.6).
"""

from dataclasses import dataclass

import numpy as np

from meshes.breaks import graded
from scenes import load_scene, run_static

CYLINDER, SPHERE = "hertz_cylinder", "hertz_sphere"
FINE = 0.02
"""Extent (m) of the elements of equal size around the contact, which reaches to 0.0167."""
GROWTH = {CYLINDER: 0.5, SPHERE: 1.0}
"""Increase of the size of elements with the distance from there."""


@dataclass(frozen=True)
class Hertz:
    """Load (N, or N/m along cylinders), half width or radius a (m) and pressure in the middle."""

    load: float
    radius: float
    peak: float

    def pressure(self, r):
        """Pressure (N/m^2) at distances from the middle (m)."""
        return self.peak * np.sqrt(np.maximum(1 - (r / self.radius) ** 2, 0.0))


@dataclass(frozen=True)
class Errors:
    """Differences from the closed form, relative to it.

    Parameters
    ----------
    radius
        Of the half width or radius, by the second moment of the pressure.
    closed
        Of the half width or radius, by the closed area.
    peak
        Of the pressure at the point nearest to the middle.
    pressure
        Of the pressure over the contact, in the mean square.
    load
        Of the sum of the contact forces, from the load.
    """

    radius: float
    closed: float
    peak: float
    pressure: float
    load: float


def scene(name, backend, *, elements, c_n, formulation, more_below=0):
    """A Hertz scene with so many elements over :data:`FINE`, graded beyond.

    Parameters
    ----------
    more_below
        Elements that the lower body has more.
    """
    of_catalogue = load_scene(name, backend=backend)
    *along, down = of_catalogue.bodies["upper"].geometry.directions
    size = of_catalogue.bodies["upper"].geometry.extent[-1][1]
    first, growth = FINE / elements, GROWTH[name]
    largest = size / (4 if name == CYLINDER else 3)
    depth = graded([0, size], largest, {0: first}, growth)
    changes = {"contacts.interface.c_n": c_n, "contacts.interface.formulation": formulation}
    for body, more, deep in (("upper", 0, depth), ("lower", more_below, -depth[::-1])):
        even = np.linspace(0, FINE, elements + more + 1)[:-1]
        beyond = graded([FINE, size], largest, {FINE: first}, growth)
        breaks = dict.fromkeys(along, np.concatenate([even, beyond])) | {down: deep}
        mesh = f"bodies.{body}.mesh.{backend}"
        changes[f"{mesh}.elements"] = [len(x) - 1 for x in breaks.values()]
        changes[f"{mesh}.through"] = {axis: x[1:-1].tolist() for axis, x in breaks.items()}
    return of_catalogue.change(changes)


def closed_form(scene):
    """The Hertz contact of a scene, and the part of it that the scene has.

    By symmetry it is half of a cylinder, a quarter of a sphere.
    """
    upper, lower = (scene.bodies[name] for name in ("upper", "lower"))
    compliance = sum((1 - b.material.nu**2) / b.material.E for b in (upper, lower))
    (load,) = scene.loads
    *sides, _ = (high - low for low, high in upper.geometry.extent)
    parts = 2 ** len(sides)
    force, R = parts * load.pressure * float(np.prod(sides)), upper.geometry.radii["x"]
    if len(sides) == 1:
        a = np.sqrt(4 * force * R * compliance / np.pi)
        return Hertz(force, a, 2 * force / (np.pi * a)), parts
    a = np.cbrt(3 * force * R * compliance / 4)
    return Hertz(force, a, 3 * force / (2 * np.pi * a**2)), parts


def radius_of(hertz):
    """Half width or radius of a contact (m)."""
    return hertz.radius


def errors(result):
    """How far a result is from the closed form."""
    hertz, parts = closed_form(result.scene)
    state = result.system.steady.contacts["interface"]
    points = result.interfaces["interface"].points
    distance = np.linalg.norm(points.x[:, :-1], axis=1)
    force = points.weight * state.pressure
    mean_square = force @ distance**2 / force.sum()
    a = hertz.radius
    if parts == 2:
        by_moment, by_area = 2 * np.sqrt(mean_square), state.closed_area
    else:
        by_moment = np.sqrt(2.5 * mean_square)
        by_area = np.sqrt(parts * state.closed_area / np.pi)
    exact = hertz.pressure(distance)
    square = points.weight @ (state.pressure - exact) ** 2 / (points.weight @ exact**2)
    return Errors(
        radius=float(by_moment / a - 1),
        closed=float(by_area / a - 1),
        peak=float(state.pressure[np.argmin(distance)] / hertz.peak - 1),
        pressure=float(np.sqrt(square)),
        load=float(parts * force.sum() / hertz.load - 1),
    )


def refined(name, backend, row, *, first_c_n, formulation, more_below=0.0):
    """Errors on a row of meshes, c_n growing with the elements; each an array over the row.

    Parameters
    ----------
    row
        Elements over :data:`FINE`.
    first_c_n
        Of the first of them.
    more_below
        Part of the elements that the lower body has more.
    """
    found = [
        errors(
            run_static(
                scene(
                    name,
                    backend,
                    elements=n,
                    c_n=first_c_n * n / row[0],
                    formulation=formulation,
                    more_below=round(more_below * n),
                )
            )
        )
        for n in row
    ]
    return {f: np.array([getattr(e, f) for e in found]) for f in Errors.__dataclass_fields__}


def rate(row, values):
    """Order in h by which values fall on a row of meshes."""
    return -np.polyfit(np.log(row), np.log(np.abs(values)), 1)[0]
