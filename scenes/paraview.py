"""Modes and static displacements of a run as files for ParaView."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from cea.body import Floats
from cea.contact.operators import Contact
from scenes.pictures import chosen_modes
from scenes.run import SceneResult
from scenes.vtu import Entry, cell_grid, in_space, point_grid, write_collection


@dataclass(frozen=True)
class _Solution:
    """A displacement to be written.

    Parameters
    ----------
    number
        Number of the mode, from 1; 0 of a static displacement.
    name
        Beginning of the names of its files.
    parts
        PETSc vectors of the unknowns, by the end of the names of the data they give.
    facts
        Numbers told of the whole solution.
    """

    number: int
    name: str
    parts: Mapping[str, Any]
    facts: Mapping[str, float]


def write_paraview(result: SceneResult, count: int, out: Path) -> list[Path]:
    """Write modes, or the displacement of a static analysis, as files for ParaView.

    Points of the bodies bear ``displacement`` (m); those of the contacts ``normal``, ``weight``
    (m^2), ``gap`` (m, penetration positive) and, where a penalty makes one of the gap,
    ``pressure`` (N/m^2). Of modes these are complex: names end in ``_real`` and ``_imag``.

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
    bodies, contacts = result.system.bodies, result.system.contacts
    is_root = next(iter(bodies.values())).comm.rank == 0
    volumes = _Collection(out, "displacement" if result.modes is None else "modes")
    surfaces = _Collection(out, "contacts")
    cells = {name: body.volume_cells() for name, body in bodies.items()}
    body_grids = {name: cell_grid(cells[name]) for name in bodies} if is_root else {}
    point_grids = {c.name: _contact_grid(c) for c in contacts} if is_root else {}
    for solution in _solutions(result, count):
        u = {name: _displacements(result, name, solution) for name in bodies}
        at_contacts = {c.name: _contact_data(c, u, solution) for c in contacts}
        for part in solution.parts.values():
            part.destroy()
        for name, grid in body_grids.items():
            for end, x in u[name].items():
                grid.point_data[f"displacement{end}"] = in_space(cells[name].values @ x)
        for name, grid in point_grids.items():
            grid.point_data.update(at_contacts[name])
        volumes.add(body_grids, solution)
        surfaces.add(point_grids, solution)
    collections = [volumes, surfaces] if contacts else [volumes]
    if is_root:
        for collection in collections:
            write_collection(collection.entries, collection.file)
    return [collection.file for collection in collections]


class _Collection:
    """A ``.pvd`` file and the folder of its grids, of the same name."""

    def __init__(self, out: Path, name: str) -> None:
        self.file = out / f"{name}.pvd"
        self.folder = out / name
        self.entries: list[Entry] = []

    def add(self, grids: Mapping[str, Any], solution: _Solution) -> None:
        """Write the grids of a solution, each a part; on other ranks there are none."""
        for part, (name, grid) in enumerate(grids.items()):
            self.folder.mkdir(parents=True, exist_ok=True)
            for fact, value in solution.facts.items():
                grid.field_data[fact] = [value]
            # Names of bodies and contacts are free text.
            file = self.folder / f"{solution.name}_{quote(name, safe=' ,')}.vtu"
            grid.save(file)
            self.entries.append(Entry(solution.number, part, file))


def _solutions(result: SceneResult, count: int) -> Iterator[_Solution]:
    """The modes by rising number, or the static displacement; their vectors are the caller's."""
    if result.modes is None:
        assert result.displacement is not None
        yield _Solution(0, "static", {"": result.displacement.copy()}, {})
        return
    everyone = range(len(result.modes.eigenvalues))
    for mode in sorted(list(dict.fromkeys([*chosen_modes(result, count), *everyone]))[:count]):
        real, imaginary = result.modes.vector(mode)
        yield _Solution(
            mode + 1,
            f"mode_{mode + 1}",
            {"_real": real, "_imag": imaginary},
            {
                "mode": mode + 1,
                "frequency": result.modes.frequencies[mode],
                "growth rate": result.modes.growth_rates[mode],
            },
        )


def _displacements(result: SceneResult, body: str, solution: _Solution) -> dict[str, Floats]:
    """Displacements (m) of the scalar dofs of a body, (num_scalar_dofs, dim), on every rank."""
    dim = result.system.bodies[body].dim
    return {
        end: result.system.displacement(x, body).reshape(-1, dim)
        for end, x in solution.parts.items()
    }


def _contact_grid(contact: Contact) -> Any:
    points = contact.interface.points
    grid = point_grid(points.x)
    grid.point_data["normal"] = in_space(points.normal)
    grid.point_data["weight"] = points.weight
    return grid


def _contact_data(
    contact: Contact, u: Mapping[str, Mapping[str, Floats]], solution: _Solution
) -> dict[str, Floats]:
    """Gap, and pressure where there is one, at all points of a contact, on every rank."""
    interface = contact.interface
    data = {}
    for end, x in solution.parts.items():
        a, b = u[contact.half.a][end], u[contact.half.b][end]
        jump = interface.trace_a @ a - interface.trace_b @ b
        gap = np.einsum("ij,ij->i", jump, interface.local_points.normal)
        data[f"gap{end}"] = np.concatenate(interface.comm.allgather(gap))
        if contact.half.form == "penalty" and contact.half.coupling != "bonded":
            data[f"pressure{end}"] = contact.pressure(x)
    return data
