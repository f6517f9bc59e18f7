"""The history of load steps as files for ParaView."""

from contextlib import ExitStack
from pathlib import Path

import numpy as np

from cea.files import folder_whole
from scenes.export.paraview import Collection, Solution, contact_grid
from scenes.pictures.grids import cell_grid, in_space, write_collection
from scenes.results.result import Result
from scenes.results.shapes import gathered_displacements

_NAME = "load_steps"


def write_load_steps(result: Result, out: Path) -> list[Path]:
    """Write the equilibria at all load steps, cut ones too, as files for ParaView.

    Points of the bodies bear ``displacement`` (m); those of contacts with a law ``contact
    pressure`` (N/m^2), ``closure`` (m) and ``contact stiffness`` (N/m^3). Time is the part of the
    load. Nothing is written where the scene asks for no steps.

    Parameters
    ----------
    result
        A run; collective, rank 0 writes.
    out
        Folder for ``load_steps.pvd`` and the folder of the ``.vtu`` files it lists.

    Returns
    -------
    list of Path
        The ``.pvd`` file, if any.
    """
    path = result.steady.path if result.steady is not None else ()
    steps = [(step.factor, step.state) for step in path if step.state is not None]
    if not steps:
        return []
    is_root = result.comm.rank == 0
    collection = Collection(out, _NAME)
    cells = {name: body.volume_cells() for name, body in result.bodies.items()}
    bodies = {name: cell_grid(each) for name, each in cells.items()} if is_root else {}
    with ExitStack() as stack:
        if is_root:
            collection.part = stack.enter_context(folder_whole(collection.folder))
        for number, (factor, state) in enumerate(steps, start=1):
            vectors = state.displacement.array_r[:, None].astype(complex)
            for name, each in cells.items():
                u = gathered_displacements(
                    result.system, name, each.values, vectors, prescribed=factor, everywhere=False
                )
                if is_root:
                    bodies[name].point_data["displacement"] = in_space(np.real(u[..., 0]))
            grids = dict(bodies)
            if is_root:
                grids |= {
                    contact.name: contact_grid(contact, state.contacts)
                    for contact in result.system.contacts
                    if contact.name in state.contacts
                }
            solution = Solution(number, f"step_{number}", ("",), {"load": factor})
            collection.add(grids, solution, factor)
    if is_root:
        write_collection(collection.entries, collection.file)
    return [collection.file]
