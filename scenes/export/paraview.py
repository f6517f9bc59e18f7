"""Modes, static displacements and load steps of a run as files for ParaView."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
import pyvista
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from cea.arrays import Floats
from cea.contact.contact import Contact, approach_along, jump_operator
from cea.eigen.blocks import times
from cea.files import folder_whole, write_whole
from cea.matrices import destroy
from cea.system.steady_state import ContactState, StepState
from scenes.pictures.grids import cell_grid, in_space
from scenes.results.result import Result
from scenes.results.shapes import displacements


class _Frame(NamedTuple):
    """What is shown at one time."""

    time: float
    stem: str  # begin of the names of its files
    facts: Mapping[str, float]
    grids: Mapping[str, Any]  # by the name of the body or contact; none but on rank 0


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
    if result.spectrum is None:
        name, modes = "displacement", []
    else:
        every = [*result.most_unstable(count), *range(len(result.modes))]
        name, modes = "modes", sorted(list(dict.fromkeys(every))[:count])
    files = [_write(_bodies(result, modes), out / f"{name}.pvd", result)]
    if result.system.contacts:
        files.append(_write(_contacts(result, modes), out / "contacts.pvd", result))
    return files


def write_load_steps(result: Result, out: Path) -> list[Path]:
    """Write the equilibria at all load steps, cut ones too, as ``load_steps.pvd``; collective.

    Points of the bodies bear ``displacement`` (m); those of contacts with a law ``contact
    pressure`` (N/m^2), ``closure`` (m) and ``contact stiffness`` (N/m^3). Time is the part of the
    load. The list of files is empty where the scene asks for no steps.
    """
    path = result.steady.path if result.steady is not None else ()
    steps = [(step.factor, step.state) for step in path if step.state is not None]
    return [_write(_steps(result, steps), out / "load_steps.pvd", result)] if steps else []


def _frames(result: Result, modes: list[int], grids: Mapping[str, Any]) -> Iterator[_Frame]:
    """A frame for each mode, or for the static solution, of grids that change between them."""
    if result.spectrum is None:
        yield _Frame(0.0, "static", {}, grids)
    for mode in modes:
        facts = {"frequency": result.frequencies[mode], "growth rate": result.growth_rates[mode]}
        yield _Frame(mode + 1, f"mode_{mode + 1}", {"mode": mode + 1, **facts}, grids)


def _bodies(result: Result, modes: list[int]) -> Iterator[_Frame]:
    """Bodies with displacements; collective."""
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    u: dict[str, Any] = {
        name: result.displacements(name, each.values, everywhere=False)[..., None]
        if result.spectrum is None
        else result.mode_shapes(name, each.values, modes, everywhere=False)
        for name, each in cells.items()
    }
    grids = {name: cell_grid(each) for name, each in cells.items() if result.comm.rank == 0}
    for i, frame in enumerate(_frames(result, modes, grids)):
        for name, grid in grids.items():
            grid.point_data.update(_parts("displacement", in_space(u[name][..., i])))
        yield frame


def _contacts(result: Result, modes: list[int]) -> Iterator[_Frame]:
    """Contact points with gaps and pressures; collective."""
    contacts = result.system.contacts
    steady = result.steady.contacts if result.steady is not None else {}
    gaps = [_gaps(result, contact, modes) for contact in contacts]
    grids = {each.name: _contact_grid(each, steady) for each in contacts if result.comm.rank == 0}
    for i, frame in enumerate(_frames(result, modes, grids)):
        for contact, gap in zip(contacts, gaps, strict=True):
            pressure = _pressure(result, contact, modes[i] if modes else None)
            if contact.name in grids:
                grids[contact.name].point_data.update(_parts("gap", gap[:, i]) | pressure)
        yield frame


def _steps(result: Result, steps: Iterable[tuple[float, StepState]]) -> Iterator[_Frame]:
    """Bodies and contact points in equilibrium under parts of the load; collective."""
    cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
    grids = {name: cell_grid(each) for name, each in cells.items() if result.comm.rank == 0}
    for number, (factor, state) in enumerate(steps, start=1):
        vectors = state.displacement.array_r[:, None].astype(complex)
        for name, each in cells.items():
            u = displacements(
                result.system, name, each.values, vectors, prescribed=factor, everywhere=False
            )
            if name in grids:
                grids[name].point_data["displacement"] = in_space(np.real(u[..., 0]))
        points = {
            contact.name: _contact_grid(contact, state.contacts)
            for contact in result.system.contacts
            if contact.name in state.contacts and result.comm.rank == 0
        }
        yield _Frame(factor, f"step_{number}", {"load": factor}, grids | points)


def _write(frames: Iterable[_Frame], file: Path, result: Result) -> Path:
    """Write a ``.pvd`` file, and beside it a folder of grids, on rank 0; collective."""
    if result.comm.rank:
        for _ in frames:
            pass
        return file
    root = Element("VTKFile", type="Collection", version="1.0")
    collection = SubElement(root, "Collection")
    with folder_whole(file.with_suffix("")) as folder:
        for frame in frames:
            for part, (label, grid) in enumerate(frame.grids.items()):
                for fact, value in frame.facts.items():
                    grid.field_data[fact] = [value]
                # Names of bodies and contacts are free text.
                name = f"{frame.stem}_{quote(label, safe=' ,')}.vtu"
                _write_grid(grid, folder / name)
                place = {"timestep": str(frame.time), "part": str(part)}
                SubElement(collection, "DataSet", place | {"file": f"{file.stem}/{name}"})
    indent(root)
    return write_whole(tostring(root, encoding="utf-8", xml_declaration=True), file)


def _write_grid(grid: Any, file: Path) -> None:
    """Write a grid whole or not at all: VTK itself only warns of a full disk."""
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    write_whole(writer.GetOutputString().encode(), file)


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
