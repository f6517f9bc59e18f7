"""Modes of your own mesh: a pad and a disc meshed by gmsh and read from its file."""

from pathlib import Path
from shutil import copy

import gmsh

from scenes import Result, load_scene, run_modes

FACES = {  # bounding boxes (mm), smaller faces first
    "bore": (-41, -41, -1, 41, 41, 11),
    "pad_face": (59, -21, 9.9, 91, 21, 10.1),
    "pad_back": (59, -21, 21.9, 91, 21, 22.1),
    "sliding_face": (-101, -101, 9.9, 101, 101, 10.1),
}


def brake(folder: Path, size: float = 14.0) -> Result:
    """Return the modes of pad and disc; write mesh (element size in mm) and scene to a folder."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 10, 100, tag=1)
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 10, 40, tag=2)
    gmsh.model.occ.cut([(3, 1)], [(3, 2)], tag=3)
    gmsh.model.occ.addBox(60, -20, 10, 30, 40, 12, tag=4)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [3], name="disc")
    gmsh.model.addPhysicalGroup(3, [4], name="pad")
    rest = {tag for _, tag in gmsh.model.getEntities(2)}
    for name, box in FACES.items():
        found = rest & {tag for _, tag in gmsh.model.getEntitiesInBoundingBox(*box, dim=2)}
        gmsh.model.addPhysicalGroup(2, sorted(found), name=name)
        rest -= found
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(str(folder / "brake.msh"))
    gmsh.finalize()
    return run_modes(load_scene(copy(Path(__file__).with_suffix(".toml"), folder)))
