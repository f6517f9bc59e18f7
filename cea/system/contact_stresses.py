"""Normal stresses on both sides of a contact: over the surfaces, along a line, at points."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.body import Body
from cea.contact.contact import Contact
from cea.material import Material
from cea.surface import Surface
from cea.surface_points import SurfaceCoordinates
from cea.system.coupled import CoupledSystem

_TIED = 1e-9  # relative difference of distances treated as equal


@dataclass(frozen=True)
class NormalStress:
    """Normal stress of one side of a contact; compression is negative."""

    # extremes over the surface (N/m^2)
    min: float
    max: float
    arc: Floats  # distances (m) along the diagonal of side a from its first corner, shape (m,)
    # normal stress on that line (N/m^2), shape (m,); NaN outside the surface
    sigma_n_along: Floats
    # sample points over the whole surface (m), shape (n, dim); empty in a stored result
    x: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    # normal stress there (N/m^2), shape (n,)
    sigma_n: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def oscillation(self) -> float:
        """Largest minus smallest normal stress over the surface (N/m^2)."""
        return self.max - self.min


def contact_stresses(
    system: CoupledSystem, contact_name: str, x: Any, samples: int
) -> dict[str, NormalStress]:
    """Return the stresses of sides "a" and "b", sampled over the surfaces and along a line."""
    contact = _contact(system, contact_name)
    line, arc, direction = _diagonal(contact, 2 * samples - 1)
    stresses = {}
    for side, surface, body, displacement in _sides(system, contact, x):
        points = surface.grid(max(2, round(samples / np.sqrt(surface.num_elements))))
        sigma_n = normal_stress(surface, points.at, displacement, body.material)
        along = _stress_at(surface, body, displacement, line, direction)
        ends = float(sigma_n.min()), float(sigma_n.max())
        stresses[side] = NormalStress(*ends, arc, along, points.x, sigma_n)
    return stresses


def stresses_at(
    system: CoupledSystem, contact_name: str, x: Any, points: Floats
) -> dict[str, Floats]:
    """Return the stresses of sides "a" and "b" at points (m) along the mean normal of a.

    Shape (n,) each, NaN for points outside a side.
    """
    contact = _contact(system, contact_name)
    direction = np.broadcast_to(_corners(contact)[1], points.shape)
    return {
        side: _stress_at(surface, body, displacement, points, direction)
        for side, surface, body, displacement in _sides(system, contact, x)
    }


def pressure_along(
    system: CoupledSystem, contact_name: str, x: Any, stiffness: float, samples: int
) -> Floats:
    """Return the pressure p g (N/m^2), positive in compression, on the line of contact_stresses."""
    contact = _contact(system, contact_name)
    line, _, direction = _diagonal(contact, 2 * samples - 1)
    gap = np.zeros(len(line))
    for side, surface, _, displacement in _sides(system, contact, x):
        found = surface.locate(line, direction, reach=surface.mesh_size)
        hit = ~found.missed
        u = surface.trace(found.at[hit]) @ displacement.reshape(-1, surface.dim)
        gap[~hit] = np.nan
        gap[hit] += (1 if side == "a" else -1) * np.einsum("ij,ij->i", u, direction[hit])
    return stiffness * gap


def normal_stress(
    surface: Surface, at: SurfaceCoordinates, displacement: Floats, material: Material
) -> Floats:
    """Return n.sigma.n (N/m^2) with the outward normal n, shape (n,); tension is positive."""
    normal = surface.normal(at)
    u = displacement.reshape(-1, surface.dim)
    gradient = np.stack([derivative @ u for derivative in surface.gradient(at)], axis=2)
    stress = material.elasticity.stress(np.moveaxis(gradient, 0, 2), surface.position(at).T)
    return np.einsum("ni,ijn,nj->n", normal, stress, normal)


def _contact(system: CoupledSystem, name: str) -> Contact:
    return next(c for c in system.contacts if c.name == name)


def _sides(
    system: CoupledSystem, contact: Contact, x: Any
) -> Iterator[tuple[str, Surface, Body, Floats]]:
    """Yield name, surface, body and full displacement of both sides."""
    for side, name, surface in (
        ("a", contact.a, contact.interface.a),
        ("b", contact.b, contact.interface.b),
    ):
        yield side, surface, system.bodies[name], system.displacement(x, name)


def _stress_at(
    surface: Surface, body: Body, displacement: Floats, x: Floats, direction: Floats
) -> Floats:
    """Return the normal stress at points located on a surface, NaN at missed points."""
    found = surface.locate(x, direction, reach=surface.mesh_size)
    stress = np.full(len(x), np.nan)
    hit = ~found.missed
    stress[hit] = normal_stress(surface, found.at[hit], displacement, body.material)
    return stress


def _corners(contact: Contact) -> tuple[Floats, Floats]:
    """Return the element corners (m) of side a, shape (n, dim), and its mean unit normal."""
    points = contact.interface.a.grid(2)
    normal = points.normal.mean(axis=0)
    return points.x, normal / np.linalg.norm(normal)


def _diagonal(contact: Contact, samples: int) -> tuple[Floats, Floats, Floats]:
    """Return a line between the farthest corners of side a, its arc length, and the normals."""
    corners, normal = _corners(contact)
    first = _farthest(corners, corners.mean(axis=0))
    last = _farthest(corners, first)
    share = np.linspace(0.0, 1.0, samples)[:, None]
    line = first + share * (last - first)
    return line, share[:, 0] * np.linalg.norm(last - first), np.broadcast_to(normal, line.shape)


def _farthest(x: Floats, origin: Floats) -> Floats:
    """Return the point farthest from an origin; of equal ones the least in coordinates."""
    distance = np.linalg.norm(x - origin, axis=1)
    tied = x[distance >= (1 - _TIED) * distance.max()]
    rounded = np.round((tied - origin) / (distance.max() or 1.0), 6)
    return tied[np.lexsort(rounded.T[::-1])[0]]
