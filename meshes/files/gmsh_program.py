"""Run as a program: a mesh file, read by gmsh, as arrays in a file of numpy."""

import json
import sys
from typing import Any


def main(mesh: str, arrays: str) -> None:
    """Read a mesh and write its arrays.

    Parameters
    ----------
    mesh
        The mesh file.
    arrays
        The file (.npz) to write: nodes by number and position; numbers and nodes of the elements of
        each kind in each entity; and, as JSON, kinds by number and physical groups.
    """
    import gmsh
    import numpy as np

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.merge(mesh)
    model = gmsh.model
    tags, positions, _ = model.mesh.getNodes()
    found: dict[str, Any] = {}
    blocks: list[list[int]] = []
    kinds: dict[str, list[object]] = {}
    for dim, entity in model.getEntities():
        for kind, numbers, nodes in zip(*model.mesh.getElements(dim, entity), strict=True):
            found[f"numbers {len(blocks)}"] = numbers.astype(np.int64)
            found[f"nodes {len(blocks)}"] = nodes.astype(np.int64)
            blocks.append([dim, int(entity), int(kind)])
            name, _, order, per_element, local, _ = model.mesh.getElementProperties(kind)
            kinds[str(kind)] = [name, order, per_element, np.asarray(local).tolist()]
    groups = [
        [
            int(dim),
            int(tag),
            model.getPhysicalName(dim, tag),
            [int(entity) for entity in model.getEntitiesForPhysicalGroup(dim, tag)],
        ]
        for dim, tag in model.getPhysicalGroups()
    ]
    what = json.dumps({"blocks": blocks, "kinds": kinds, "groups": groups})
    np.savez(arrays, tags=tags.astype(np.int64), positions=positions, what=what, **found)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except Exception as error:  # gmsh raises what it says in its own words
        sys.exit(str(error))
