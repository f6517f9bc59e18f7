"""Modes and static displacements of a run as files for ParaView."""

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from cea.arrays import Complexes, Floats
from cea.contact.contact import Contact
from cea.files import folder_whole
from cea.matrices import destroy
from cea.system.steady_state import ContactState
from scenes.pictures.grids import (
    Entry,
    cell_grid,
    in_space,
    point_grid,
    write_collection,
    write_grid,
)
from scenes.results.result import Result
from scenes.results.shapes import displacements


@dataclass(frozen=True)
class Solution:
    """A displacement to be written.

    Parameters
    ----------
    number
        Number of the mode or the load step, from 1; 0 of a static displacement.
    name
        Beginning of the names of its files.
    ends
        Ends of the names of its data: of the real and the imaginary part, or of the real one.
    facts
        Numbers told of the whole solution.
    """

    number: int
    name: str
    ends: tuple[str, ...]
    facts: Mapping[str, float]

    def parts(self, name: str, values: Complexes | Floats) -> dict[str, Floats]:
        """Real data under their names."""
        return {
            f"{name}{end}": part
            for end, part in zip(self.ends, (values.real, values.imag), strict=False)
        }


def write_paraview(result: Result, count: int, out: Path) -> list[Path]:
    """Write modes, or the displacement of a static analysis, as files for ParaView.

    Points of the bodies bear ``displacement`` (m); those of the contacts ``normal``, ``weight``
    (m^2), ``gap`` (m, penetration positive) and, where a penalty makes one of the gap,
    ``pressure`` (N/m^2). Of modes these are complex: names end in ``_real`` and ``_imag``. Where a
    state of steady sliding was sought the points bear its ``contact pressure`` (N/m^2), ``closure``
    (m) and ``contact stiffness`` (N/m^3) too, the same beside every mode.

    Parameters
    ----------
    result
        A run; collective, rank 0 writes.
    count
        Number of modes at most: the most unstable ones, then the others by rising frequency.
    out
        Folder for ``modes.pvd`` (``displacement.pvd`` of a static analysis) with the bodies as
        parts, ``contacts.pvd`` with the contact points where there are any, and beside each a
        folder of the ``.vtu`` files it lists. Time is the number of the mode.

    Returns
    -------
    list of Path
        The ``.pvd`` files.
    """
    bodies, contacts = result.bodies, result.system.contacts
    is_root = next(iter(bodies.values())).comm.rank == 0
    modes = _chosen(result, count) if result.spectrum is not None else []
    solutions = _solutions(result, modes)
    volumes = Collection(out, "modes" if result.spectrum is not None else "displacement")
    surfaces = Collection(out, "contacts")
    cells = {name: body.volume_cells() for name, body in bodies.items()}
    u = {
        name: result.mode_shapes(name, cells[name].values, modes, everywhere=False)
        if result.spectrum is not None
        else result.displacements(name, cells[name].values, everywhere=False)[..., None]
        for name in bodies
    }
    gaps = {contact.name: _gaps(result, contact, modes) for contact in contacts}
    steady = result.steady.contacts if result.steady is not None else {}
    body_grids = {name: cell_grid(cells[name]) for name in bodies} if is_root else {}
    point_grids = {c.name: contact_grid(c, steady) for c in contacts} if is_root else {}
    collections = [volumes, surfaces] if contacts else [volumes]
    with ExitStack() as stack:
        if is_root:
            for collection in collections:
                collection.part = stack.enter_context(folder_whole(collection.folder))
        for i, solution in enumerate(solutions):
            pressures = {c.name: _pressure(result, c, solution) for c in contacts}
            for name, grid in body_grids.items():
                for label, x in solution.parts("displacement", u[name][..., i]).items():
                    grid.point_data[label] = in_space(x)
            for name, grid in point_grids.items():
                grid.point_data.update(solution.parts("gap", gaps[name][:, i]) | pressures[name])
            volumes.add(body_grids, solution)
            surfaces.add(point_grids, solution)
    if is_root:
        for collection in collections:
            write_collection(collection.entries, collection.file)
    return [collection.file for collection in collections]


class Collection:
    """A ``.pvd`` file and the folder of its grids, of the same name."""

    def __init__(self, out: Path, name: str) -> None:
        self.file = out / f"{name}.pvd"
        self.folder = out / name
        self.part = self.folder  # where its grids are written until it is whole
        self.entries: list[Entry] = []

    def add(self, grids: Mapping[str, Any], solution: Solution, time: float | None = None) -> None:
        """Write the grids of a solution, each a part; on other ranks there are none.

        Time is by default its number.
        """
        for part, (name, grid) in enumerate(grids.items()):
            for fact, value in solution.facts.items():
                grid.field_data[fact] = [value]
            # Names of bodies and contacts are free text.
            file = self.folder / f"{solution.name}_{quote(name, safe=' ,')}.vtu"
            write_grid(grid, self.part / file.name)
            shown = solution.number if time is None else time
            self.entries.append(Entry(shown, part, file))


def _chosen(result: Result, count: int) -> list[int]:
    """The most unstable modes, then others by rising frequency: so many, by rising number."""
    every = [*result.most_unstable(count), *range(len(result.modes))]
    return sorted(list(dict.fromkeys(every))[:count])


def _solutions(result: Result, modes: list[int]) -> list[Solution]:
    """Some modes, or the static displacement."""
    if result.spectrum is None:
        return [Solution(0, "static", ("",), {})]
    return [
        Solution(
            mode + 1,
            f"mode_{mode + 1}",
            ("_real", "_imag"),
            {
                "mode": mode + 1,
                "frequency": result.frequencies[mode],
                "growth rate": result.growth_rates[mode],
            },
        )
        for mode in modes
    ]


def contact_grid(contact: Contact, states: Mapping[str, ContactState]) -> Any:
    """Points of a contact with what it carries in steady sliding, if anything is known of that.

    Parameters
    ----------
    contact
        The contact.
    states
        States of half passes by name.
    """
    points = contact.interface.points
    grid = point_grid(points.x)
    grid.point_data["normal"] = in_space(points.normal)
    grid.point_data["weight"] = points.weight
    if contact.name in states:
        state = states[contact.name]
        grid.point_data["contact pressure"] = state.pressure
        grid.point_data["closure"] = state.closure
        grid.point_data["contact stiffness"] = state.stiffness
    return grid


def _gaps(result: Result, contact: Contact, modes: list[int]) -> Complexes:
    """Gaps (m) at all points of a contact, (points, solutions), on every rank."""
    interface = contact.interface
    if result.spectrum is not None:
        vectors, prescribed = result.modes.vectors[:, modes], 0.0
    else:
        vectors, prescribed = result.displacement.array[:, None].astype(complex), 1.0
    jump, opposite = (
        displacements(result.system, body, trace, vectors, prescribed=prescribed)
        for body, trace in (
            (contact.a, interface.trace_a),
            (contact.b, interface.trace_b),
        )
    )
    jump -= opposite
    gap = np.einsum("ijk,ij->ik", jump, interface.local_points.normal)
    return np.concatenate(interface.comm.allgather(gap))


def _pressure(result: Result, contact: Contact, solution: Solution) -> dict[str, Floats]:
    """Pressure (N/m^2) at all points of a contact that has one, on every rank."""
    if not contact.has_pressure:
        return {}
    if result.spectrum is None:
        if not contact.law.linear:
            return {}  # the contact pressure of the state stands there
        pressure = contact.pressure(result.displacement)
        if contact.prescribed is not None:
            pressure = pressure + contact.slope * contact.prescribed
        return {"pressure": pressure}
    if not np.isfinite(result.relative_stiffness(contact.pair)):
        return {}
    parts = result.modes.vector(solution.number - 1)
    data = {
        f"pressure{end}": result.relative_stiffness(contact.pair) * contact.pressure(part)
        for end, part in zip(solution.ends, parts, strict=True)
    }
    destroy(*parts)
    return data
