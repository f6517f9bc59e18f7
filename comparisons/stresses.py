"""Normal stresses of both sides of a contact: over the whole surfaces and along a line."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cea.body import Body, Floats, Surface
from cea.stress import normal_stress
from cea.system import Contact, CoupledSystem

_TIED = 1e-9
"""Relative difference of distances that counts as none."""


@dataclass(frozen=True)
class SideStress:
    """Normal stress of one side of a contact; compression is negative.

    Parameters
    ----------
    x
        Sample points over the whole surface (m), shape (n, dim).
    sigma_n
        Normal stress there (N/m^2), shape (n,).
    arc
        Distances (m) along the diagonal of side a from its first corner, shape (m,).
    sigma_n_along
        Normal stress on that line (N/m^2), shape (m,); NaN where the line leaves the surface.
    """

    x: Floats
    sigma_n: Floats
    arc: Floats
    sigma_n_along: Floats

    @property
    def oscillation(self) -> float:
        """Largest minus smallest normal stress over the surface (N/m^2)."""
        return float(np.ptp(self.sigma_n))


def contact_stresses(
    system: CoupledSystem, contact_name: str, x: Any, samples: int
) -> dict[str, SideStress]:
    """Stresses of sides "a" and "b" of a contact.

    Parameters
    ----------
    system
        The coupled system.
    contact_name
        Name of the contact.
    x
        Unknowns, PETSc vector.
    samples
        Points across a surface, and along the line.
    """
    contact = next(c for c in system.contacts if c.name == contact_name)
    line, arc, direction = _diagonal(contact, 2 * samples - 1)
    return {
        side: _side_stress(
            surface,
            system.bodies[body],
            system.displacement(x, body),
            samples,
            line,
            arc,
            direction,
        )
        for side, body, surface in (
            ("a", contact.body_a, contact.interface.a),
            ("b", contact.body_b, contact.interface.b),
        )
    }


def _side_stress(
    surface: Surface,
    body: Body,
    displacement: Floats,
    samples: int,
    line: Floats,
    arc: Floats,
    direction: Floats,
) -> SideStress:
    points = surface.grid(max(2, round(samples / np.sqrt(surface.num_elements))))
    found = surface.locate(line, direction, reach=surface.mesh_size)
    along = np.full(len(line), np.nan)
    hit = ~found.missed
    along[hit] = normal_stress(surface, found.at[hit], displacement, body.material)
    return SideStress(
        points.x, normal_stress(surface, points.at, displacement, body.material), arc, along
    )


def _diagonal(contact: Contact, samples: int) -> tuple[Floats, Floats, Floats]:
    """Line between the contact points farthest apart, its arc length and the normals to search."""
    points = contact.interface.points
    first = _farthest(points.x, points.x.mean(axis=0))
    last = _farthest(points.x, first)
    share = np.linspace(0.0, 1.0, samples)[:, None]
    normal = points.normal.mean(axis=0)
    normal /= np.linalg.norm(normal)
    line = first + share * (last - first)
    return line, share[:, 0] * np.linalg.norm(last - first), np.broadcast_to(normal, line.shape)


def _farthest(x: Floats, origin: Floats) -> Floats:
    """Point farthest from an origin; of equally far ones, that of the least coordinates.

    Points come in an order, and with rounding, that depend on how meshes are shared out.
    """
    distance = np.linalg.norm(x - origin, axis=1)
    tied = x[distance >= (1 - _TIED) * distance.max()]
    rounded = np.round((tied - origin) / (distance.max() or 1.0), 6)
    return tied[np.lexsort(rounded.T[::-1])[0]]
