"""How far pressures of steady sliding can be trusted, given the facets of curved sides.

The law meets closures that may be far smaller than what facets leave of a curved surface. Of
shapes the true surface is known, and initial gaps are its own; what is left is that facets are
tilted against it: an approach u of the sides that slides along the true surface seems to close

    (n - n_true).u

at a point of the rule, of either sign in a facet: projected on the traces of a side most of it
cancels. Of meshes from files the surface is not known: its distance from
the facets is estimated, and initial gaps below that count as zero.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from cea.contact.contact import Contact, approach_along
from cea.contact.laws import NormalCompliance
from cea.ranks import agreed
from cea.system.coupled import CoupledSystem
from cea.warned import ResultWarning

if TYPE_CHECKING:
    from cea.system.steady_state import ContactState, SteadySliding

_ALLOWED = 0.01
"""Relative error of pressures in the mean square that is told; peaks err by two or three times it.

With rings that are shrunk into each other the estimate is right to a few per cent up to 0.1, at
degrees 1 to 3.
"""
_ROUNDED = 1e-9
"""Distance, relative to the mesh size, that is rounding of the numbers in a mesh file."""


def gaps_as_zero(contact: Contact) -> Iterator[ResultWarning]:
    """Initial gaps that are not above the error of the geometry of mesh files; collective."""
    interface = contact.interface
    with agreed(interface.comm):
        distance = np.abs(interface.true_distance)
        within = np.where(interface.initial_gap == 0, distance, 0.0)
        local = interface.local_points.weight[within > 0].sum(), within, interface.geometry_error
    areas, gaps, errors = zip(*interface.comm.allgather(local), strict=True)
    largest, error = (float(np.concatenate(parts).max(initial=0.0)) for parts in (gaps, errors))
    if largest > _ROUNDED * min(interface.a.mesh_size, interface.b.mesh_size):
        fraction = float(sum(areas) / interface.points.weight.sum())
        yield ResultWarning(
            "gaps-as-zero",
            f"initial gaps up to {largest:.2g} m, on {100 * fraction:.3g} % of the area of "
            f"contacts.{contact.name}, are not above the error of its mesh from a file, up to "
            f"{error:.2g} m, and count as zero",
            {
                **{"contact": contact.pair, "half": contact.name, "gap": largest},
                **{"geometry_error": error, "fraction": fraction},
            },
        )


def geometry_error(
    system: CoupledSystem, steady: "SteadySliding", contact: Contact, state: "ContactState"
) -> Iterator[ResultWarning]:
    """Closures that do not stand out from the errors of curved facets; collective."""
    interface, law = contact.interface, contact.law
    assert isinstance(law, NormalCompliance)
    with agreed(interface.comm):
        tilt = interface.a.normal_error(interface.local_points.at)
        local = interface.geometry_error
    seeming = approach_along(system.bodies, contact, tilt, steady.displacement)
    error = np.concatenate(interface.comm.allgather(local)) + np.abs(contact.met(seeming))
    force = interface.points.weight * state.pressure
    if not force.any():
        return
    closure = float(force @ state.closure / force.sum())
    of_gaps = float(np.sqrt(force @ error**2 / force.sum()))
    relative = law.m * of_gaps / closure
    if relative > _ALLOWED:
        yield ResultWarning(
            "geometry-error",
            f"closures of contacts.{contact.name}, {closure:.2g} m in the mean, are not far above "
            f"what its curved facets leave undecided, {of_gaps:.2g} m: pressures at its points "
            + (
                f"may be off by {100 * relative:.2g} % in the mean square"
                if relative < 1
                else "cannot be relied on"
            ),
            {
                **{"contact": contact.pair, "half": contact.name, "closure": closure},
                **{"geometry_error": of_gaps, "relative": relative},
            },
        )
