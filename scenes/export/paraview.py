"""Modes, static displacements and load steps of a run as files for ParaView."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from cea.arrays import Complexes, Floats
from cea.contact.contact import Contact
from cea.files import folder_whole
from cea.matrices import destroy
from cea.system.steady_state import ContactState
from scenes.pictures.grids import cell_grid, in_space, point_grid, write_collection, write_grid
from scenes.results.result import Result
from scenes.results.shapes import displacements, gathered_displacements

_ENDS = ("_real", "_imag")
"""Ends of the names of complex data."""


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
    of_modes, contacts = result.spectrum is not None, result.system.contacts
    modes = _chosen(result, count) if of_modes else []
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    u = {
        name: result.mode_shapes(name, each.values, modes, everywhere=False)
        if of_modes
        else result.displacements(name, each.values, everywhere=False)[..., None]
        for name, each in cells.items()
    }
    gaps = {contact.name: _gaps(result, contact, modes) for contact in contacts}
    steady = result.steady.contacts if result.steady is not None else {}
    is_root = result.comm.rank == 0
    bodies = {name: cell_grid(each) for name, each in cells.items()} if is_root else {}
    points = {c.name: contact_grid(c, steady) for c in contacts} if is_root else {}
    names = [("modes" if of_modes else "displacement", bodies)]
    names += [("contacts", points)] if contacts else []
    with _collections(out, [name for name, _ in names], is_root) as written:
        for i, mode in enumerate(modes or [None]):
            pressures = {contact.name: _pressure(result, contact, mode) for contact in contacts}
            for name, grid in bodies.items():
                for end, x in _parts(u[name][..., i], of_modes):
                    grid.point_data[f"displacement{end}"] = in_space(x)
            for name, grid in points.items():
                for end, gap in _parts(gaps[name][:, i], of_modes):
                    grid.point_data[f"gap{end}"] = gap
                grid.point_data.update(pressures[name])
            facts, stem = {}, "static"
            if mode is not None:
                stem, facts = f"mode_{mode + 1}", _facts(result, mode)
            for (_, grids), add in zip(names, written, strict=True):
                add(grids, stem, facts, 0 if mode is None else mode + 1)
    return [out / f"{name}.pvd" for name, _ in names]


def write_load_steps(result: Result, out: Path) -> list[Path]:
    """Write the equilibria at all load steps, cut ones too, as files for ParaView.

    Points of the bodies bear ``displacement`` (m); those of contacts with a law ``contact
    pressure`` (N/m^2), ``closure`` (m) and ``contact stiffness`` (N/m^3). Time is the part of the
    load.

    Parameters
    ----------
    result
        A run; collective, rank 0 writes.
    out
        Folder for ``load_steps.pvd`` and the folder of the ``.vtu`` files it lists.

    Returns
    -------
    list of Path
        The ``.pvd`` file; none where the scene asks for no steps.
    """
    path = result.steady.path if result.steady is not None else ()
    steps = [(step.factor, step.state) for step in path if step.state is not None]
    if not steps:
        return []
    is_root = result.comm.rank == 0
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    bodies = {name: cell_grid(each) for name, each in cells.items()} if is_root else {}
    with _collections(out, ["load_steps"], is_root) as (add,):
        for number, (factor, state) in enumerate(steps, start=1):
            vectors = state.displacement.array_r[:, None].astype(complex)
            for name, each in cells.items():
                u = gathered_displacements(
                    result.system, name, each.values, vectors, prescribed=factor, everywhere=False
                )
                if is_root:
                    bodies[name].point_data["displacement"] = in_space(np.real(u[..., 0]))
            points = {
                contact.name: contact_grid(contact, state.contacts)
                for contact in result.system.contacts
                if is_root and contact.name in state.contacts
            }
            add(bodies | points, f"step_{number}", {"load": factor}, factor)
    return [out / "load_steps.pvd"]


@contextmanager
def _collections(out: Path, names: list[str], is_root: bool) -> Iterator[list[Any]]:
    """For each ``.pvd`` file a function that writes grids, of the same time, to its folder."""
    if not is_root:
        yield [lambda *arguments: None for _ in names]
        return
    if not names:
        yield []
        return
    name, *others = names
    entries: list[tuple[float, int, Path]] = []
    with folder_whole(out / name) as part, _collections(out, others, is_root) as rest:

        def add(
            grids: Mapping[str, Any], stem: str, facts: Mapping[str, float], time: float
        ) -> None:
            for number, (label, grid) in enumerate(grids.items()):
                for fact, value in facts.items():
                    grid.field_data[fact] = [value]
                # Names of bodies and contacts are free text.
                file = f"{stem}_{quote(label, safe=' ,')}.vtu"
                write_grid(grid, part / file)
                entries.append((time, number, Path(name) / file))

        yield [add, *rest]
    write_collection(entries, out / f"{name}.pvd")


def _chosen(result: Result, count: int) -> list[int]:
    """The most unstable modes, then others by rising frequency: so many, by rising number."""
    every = [*result.most_unstable(count), *range(len(result.modes))]
    return sorted(list(dict.fromkeys(every))[:count])


def _parts(values: Any, of_modes: bool) -> list[tuple[str, Floats]]:
    """Real data with the ends of their names."""
    return list(zip(_ENDS, (values.real, values.imag), strict=True)) if of_modes else [("", values)]


def _facts(result: Result, mode: int) -> dict[str, float]:
    return {
        "mode": mode + 1,
        "frequency": result.frequencies[mode],
        "growth rate": result.growth_rates[mode],
    }


def contact_grid(contact: Contact, states: Mapping[str, ContactState]) -> Any:
    """Points of a contact with what it carries in steady sliding, if anything is known of that."""
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
    sides = ((contact.a, interface.trace_a), (contact.b, interface.trace_b))
    jump, opposite = (
        displacements(result.system, body, trace, vectors, prescribed=prescribed)
        for body, trace in sides
    )
    gap = np.einsum("ijk,ij->ik", jump - opposite, interface.local_points.normal)
    found = np.concatenate(interface.comm.allgather(gap))
    return found if result.spectrum is not None else found.real


def _pressure(result: Result, contact: Contact, mode: int | None) -> dict[str, Floats]:
    """Pressure (N/m^2) at all points of a contact that has one, on every rank."""
    if not contact.has_pressure:
        return {}
    if mode is None:
        if not contact.law.linear:
            return {}  # the contact pressure of the state stands there
        pressure = contact.pressure(result.displacement)
        if contact.prescribed is not None:
            pressure = pressure + contact.slope * contact.prescribed
        return {"pressure": pressure}
    stiffness = result.relative_stiffness(contact.pair)
    if not np.isfinite(stiffness):
        return {}
    parts = result.modes.vector(mode)
    data = {
        f"pressure{end}": stiffness * contact.pressure(part)
        for end, part in zip(_ENDS, parts, strict=True)
    }
    destroy(*parts)
    return data
