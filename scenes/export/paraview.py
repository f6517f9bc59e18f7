"""Modes, static displacements and load steps of a run as files for ParaView."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pyvista

from cea.arrays import Floats
from cea.contact.contact import Contact, approach_along, jump_operator
from cea.files import folder_whole
from cea.matrices import destroy
from cea.system.steady_state import ContactState
from scenes.pictures.grids import cell_grid, in_space, write_collection, write_grid
from scenes.results.result import Result
from scenes.results.shapes import displacements, times


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
    modes = [None] if result.spectrum is None else _chosen(result, count)
    chosen = [mode for mode in modes if mode is not None]
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    u = {
        name: result.mode_shapes(name, each.values, chosen, everywhere=False)
        if result.spectrum is not None
        else result.displacements(name, each.values, everywhere=False)[..., None]
        for name, each in cells.items()
    }
    contacts, is_root = result.system.contacts, result.comm.rank == 0
    gaps = {contact.name: _gaps(result, contact, chosen) for contact in contacts}
    steady = result.steady.contacts if result.steady is not None else {}
    bodies = {name: cell_grid(each) for name, each in cells.items()} if is_root else {}
    points = {c.name: _contact_grid(c, steady) for c in contacts} if is_root else {}
    name = "displacement" if result.spectrum is None else "modes"
    others = _collection(out, "contacts", is_root) if contacts else nullcontext(_nothing)
    with _collection(out, name, is_root) as add_bodies, others as add_contacts:
        for i, mode in enumerate(modes):
            pressures = {contact.name: _pressure(result, contact, mode) for contact in contacts}
            for body, grid in bodies.items():
                grid.point_data.update(_parts("displacement", in_space(u[body][..., i])))
            for contact, grid in points.items():
                grid.point_data.update(_parts("gap", gaps[contact][:, i]) | pressures[contact])
            stem, facts = _label(result, mode)
            for add, grids in ((add_bodies, bodies), (add_contacts, points)):
                add(grids, stem, facts, 0 if mode is None else mode + 1)
    return [out / f"{each}.pvd" for each in (name, *(["contacts"] if contacts else []))]


def write_load_steps(result: Result, out: Path) -> list[Path]:
    """Write the equilibria at all load steps, cut ones too, as ``load_steps.pvd``; collective.

    Points of the bodies bear ``displacement`` (m); those of contacts with a law ``contact
    pressure`` (N/m^2), ``closure`` (m) and ``contact stiffness`` (N/m^3). Time is the part of the
    load. The list of files is empty where the scene asks for no steps.
    """
    path = result.steady.path if result.steady is not None else ()
    steps = [(step.factor, step.state) for step in path if step.state is not None]
    if not steps:
        return []
    is_root = result.comm.rank == 0
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    bodies = {name: cell_grid(each) for name, each in cells.items()} if is_root else {}
    with _collection(out, "load_steps", is_root) as add:
        for number, (factor, state) in enumerate(steps, start=1):
            vectors = state.displacement.array_r[:, None].astype(complex)
            for name, each in cells.items():
                u = displacements(
                    result.system, name, each.values, vectors, prescribed=factor, everywhere=False
                )
                if is_root:
                    bodies[name].point_data["displacement"] = in_space(np.real(u[..., 0]))
            points = {
                contact.name: _contact_grid(contact, state.contacts)
                for contact in result.system.contacts
                if is_root and contact.name in state.contacts
            }
            add(bodies | points, f"step_{number}", {"load": factor}, factor)
    return [out / "load_steps.pvd"]


def _nothing(*_: Any) -> None:
    """Write nothing: of other ranks, and where there are no contacts."""


@contextmanager
def _collection(out: Path, name: str, is_root: bool) -> Iterator[Callable[..., None]]:
    """A function that writes grids of one time to the folder of a ``.pvd`` file."""
    if not is_root:
        yield _nothing
        return
    entries: list[tuple[float, int, Path]] = []
    with folder_whole(out / name) as part:

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

        yield add
    write_collection(entries, out / f"{name}.pvd")


def _chosen(result: Result, count: int) -> list[int | None]:
    """The most unstable modes, then others by rising frequency: so many, by rising number."""
    every = [*result.most_unstable(count), *range(len(result.modes))]
    return [*sorted(list(dict.fromkeys(every))[:count])]


def _label(result: Result, mode: int | None) -> tuple[str, dict[str, float]]:
    """Begin of the names of the files of a mode, and what they tell of it."""
    if mode is None:
        return "static", {}
    facts = {"frequency": result.frequencies[mode], "growth rate": result.growth_rates[mode]}
    return f"mode_{mode + 1}", {"mode": mode + 1, **facts}


def _parts(name: str, values: Any) -> dict[str, Floats]:
    """Real data by name; of complex ones both parts."""
    if not np.iscomplexobj(values):
        return {name: values}
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _contact_grid(contact: Contact, states: Mapping[str, ContactState]) -> Any:
    """Points of a contact with what it carries in steady sliding, if anything is known of that."""
    points = contact.interface.points
    grid = pyvista.PolyData(in_space(points.x)).cast_to_unstructured_grid()
    grid.point_data["normal"] = in_space(points.normal)
    grid.point_data["weight"] = points.weight
    if contact.name in states:
        state = states[contact.name]
        grid.point_data["contact pressure"] = state.pressure
        grid.point_data["closure"] = state.closure
        grid.point_data["contact stiffness"] = state.stiffness
    return grid


def _gaps(result: Result, contact: Contact, modes: list[int]) -> Any:
    """Gaps (m) at all points of a contact, (points, solutions), on every rank."""
    normal = contact.interface.local_points.normal
    if result.spectrum is None:
        sides = (contact.a, contact.b)
        moved = {name: result.system.displacement(result.displacement, name) for name in sides}
        return approach_along(contact, normal, moved)[:, None]
    jump = jump_operator(result.bodies, contact, normal)
    gap = times(jump, result.modes.vectors[:, modes])
    destroy(jump)
    return np.concatenate(contact.interface.comm.allgather(gap))


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
    name, modes = f"contacts.{contact.pair}.P", result.modes
    # Where steady sliding makes P, and nothing changes it, it is no parameter.
    solved = modes.values.get(name)
    stiffness = 1.0 if solved is None else solved / modes.pencil.parameters[name].value
    if not np.isfinite(stiffness):
        return {}
    real, imaginary = result.modes.vector(mode)
    pressure = contact.pressure(real) + 1j * contact.pressure(imaginary)
    destroy(real, imaginary)
    return _parts("pressure", stiffness * pressure)
