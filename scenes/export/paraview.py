"""Export of modes, static displacements and load steps to ParaView."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
import pyvista
from scipy.sparse import csr_array
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from cea.arrays import Floats
from cea.contact.contact import Contact, approach_along, jump_operator
from cea.eigen.block_products import times
from cea.files import write_whole
from cea.matrices import destroy
from cea.system.steady_state import ContactState
from scenes.results.pictures import cell_grid, in_space
from scenes.results.result import Result
from scenes.results.shapes import displacements


class _Frame(NamedTuple):
    """One time of a ParaView collection."""

    time: float
    stem: str  # prefix of its file names
    facts: Mapping[str, float]


type _Fields = Mapping[str, Any]
"""Fields of one grid by name: arrays whose last axis is the frame."""


def write_paraview(result: Result, count: int, out: Path) -> list[Path]:
    """Write modes, or the displacement of a static analysis, as files for ParaView.

    Bodies have ``displacement`` (m); contact points have ``normal``, ``weight`` (m^2) and ``gap``
    (m, penetration positive). Displacements and gaps of modes are complex: their names end in
    ``_real`` and ``_imag``. Contact points of a static analysis have ``pressure`` (N/m^2) if a
    penalty relates it to the gap. With steady sliding they have ``contact pressure`` (N/m^2),
    ``closure`` (m) and ``contact stiffness`` (N/m^3) of that state, repeated for every mode.

    Parameters
    ----------
    result
        Result of a run; collective, rank 0 writes.
    count
        Largest number of modes: the most unstable ones, then others in order of frequency.
    out
        Folder for ``modes.pvd`` (``displacement.pvd`` for a static analysis) with the bodies as
        parts, ``contacts.pvd`` with the contact points if there are any, and a folder of ``.vtu``
        files for each. Time is the number of the mode. With load steps there is
        ``load_steps.pvd``, whose time is the load factor; its points of contacts with a law have
        the fields of steady sliding.

    Returns
    -------
    list of Path
        The ``.pvd`` files.
    """
    name, modes, frames = "displacement", list[int](), [_Frame(0.0, "static", {})]
    if result.spectrum is not None:
        every = [*result.most_unstable(count), *range(len(result.modes))]
        name, modes = "modes", sorted(list(dict.fromkeys(every))[:count])
        frames = [_mode_frame(result, mode) for mode in modes]

    def shapes(body: str, values: csr_array) -> Any:
        if result.spectrum is None:
            return result.displacements(body, values, everywhere=False)[..., None]
        return result.mode_shapes(body, values, modes, everywhere=False)

    files = [_write(out / f"{name}.pvd", result, frames, _bodies(result, shapes))]
    if contacts := result.system.contacts:
        steady = result.steady.contacts if result.steady is not None else {}
        grids: dict[str, tuple[Any, _Fields]] = {}
        for each in contacts:
            grid, own = _points(each), steady.get(each.name)
            grid.point_data.update({} if own is None else _carried(own))
            gaps = {"gap": _gaps(result, each, modes)}
            grids[each.name] = grid, gaps | _static_pressure(result, each)
        files.append(_write(out / "contacts.pvd", result, frames, grids))
    return files + _load_steps(result, out / "load_steps.pvd")


def _load_steps(result: Result, file: Path) -> list[Path]:
    """Write the equilibria of all load steps, with cut ones, if the scene has any; collective."""
    path = result.steady.path if result.steady is not None else ()
    steps = [(s.factor, s.displacement, s.contacts) for s in path if s.displacement is not None]
    if not steps:
        return []
    frames = [_Frame(f, f"step_{i}", {"load": f}) for i, (f, *_) in enumerate(steps, start=1)]

    def shapes(body: str, values: csr_array) -> Floats:
        every = []
        for factor, displacement, _ in steps:
            where = result.system, body, values, displacement.array_r[:, None].astype(complex)
            every.append(displacements(*where, prescribed=factor, everywhere=False).real)
        return np.concatenate(every, axis=-1)

    grids = _bodies(result, shapes)
    for contact in result.system.contacts:
        carried = [_carried(states[contact.name]) for *_, states in steps if contact.name in states]
        if carried:
            fields = {n: np.stack([each[n] for each in carried], axis=-1) for n in carried[0]}
            grids[contact.name] = _points(contact), fields
    return [_write(file, result, frames, grids)]


def _bodies(
    result: Result, shapes: Callable[[str, csr_array], Any]
) -> dict[str, tuple[Any, _Fields]]:
    """Return the grid and displacements of each body, given by its name and basis functions."""
    grids: dict[str, tuple[Any, _Fields]] = {}
    for name, body in result.bodies.items():
        cells = body.space.volume_cells()
        grid = cell_grid(cells) if result.comm.rank == 0 else None
        grids[name] = grid, {"displacement": shapes(name, cells.values)}
    return grids


def _mode_frame(result: Result, mode: int) -> _Frame:
    facts = {"frequency": result.frequencies[mode], "growth rate": result.growth_rates[mode]}
    return _Frame(mode + 1, f"mode_{mode + 1}", {"mode": mode + 1, **facts})


def _write(
    file: Path, result: Result, frames: list[_Frame], grids: Mapping[str, tuple[Any, _Fields]]
) -> Path:
    """Write a folder with a file for each grid and frame, then a ``.pvd`` file, on rank 0."""
    if result.comm.rank:
        return file
    root = Element("VTKFile", type="Collection", version="1.0")
    collection = SubElement(root, "Collection")
    for i, frame in enumerate(frames):
        for part, (label, (grid, fields)) in enumerate(grids.items()):
            for fact, value in frame.facts.items():
                grid.field_data[fact] = [value]
            for field, values in fields.items():
                grid.point_data.update(_parts(field, values[..., i]))
            # Names of bodies and contacts may contain any characters.
            name = f"{frame.stem}_{quote(label, safe=' ,')}.vtu"
            _write_grid(grid, file.with_suffix("") / name)
            place = {"timestep": str(frame.time), "part": str(part)}
            SubElement(collection, "DataSet", place | {"file": f"{file.stem}/{name}"})
    indent(root)
    return write_whole(tostring(root, encoding="utf-8", xml_declaration=True), file)


def _parts(name: str, values: Any) -> dict[str, Floats]:
    """Return real fields by name, with 3D vectors and complex fields as two parts."""
    values = in_space(values) if values.ndim > 1 else values
    if not np.iscomplexobj(values):
        return {name: values}
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _write_grid(grid: Any, file: Path) -> None:
    """Write a grid atomically; VTK itself only warns if the disk is full."""
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    write_whole(writer.GetOutputString().encode(), file)


def _points(contact: Contact) -> Any:
    """Return the grid of the points of a contact, with normals and weights."""
    points = contact.interface.points
    grid = pyvista.PolyData(in_space(points.x)).cast_to_unstructured_grid()
    grid.point_data["normal"] = in_space(points.normal)
    grid.point_data["weight"] = points.weight
    return grid


def _carried(state: ContactState) -> dict[str, Floats]:
    """Return the fields of a contact in steady sliding at its points."""
    carried = {"contact pressure": state.pressure, "closure": state.closure}
    return carried | {"contact stiffness": state.stiffness}


def _gaps(result: Result, contact: Contact, modes: list[int]) -> Any:
    """Return the gaps (m) at all points of a contact, (points, solutions), on every rank."""
    normal = contact.interface.local_points.normal
    if result.spectrum is None:
        sides = (contact.a, contact.b)
        moved = {name: result.system.displacement(result.displacement, name) for name in sides}
        return approach_along(contact, normal, moved)[:, None]
    jump = jump_operator(result.bodies, contact, normal)
    gap = times(jump, result.modes.vectors[:, modes])
    destroy(jump)
    return np.concatenate(contact.interface.comm.allgather(gap))


def _static_pressure(result: Result, contact: Contact) -> dict[str, Any]:
    """Return the pressure (N/m^2) at all points of a contact of given stiffness, (points, 1)."""
    if result.spectrum is not None or not (contact.has_pressure and contact.law.linear):
        return {}
    pressure = contact.pressure(result.displacement)
    if contact.prescribed is not None:
        pressure = pressure + contact.slope * contact.prescribed
    return {"pressure": pressure[:, None]}
