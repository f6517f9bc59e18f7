"""A brake of one's own: a pad and a disc meshed with gmsh, and read from the file it writes."""

from pathlib import Path
from tempfile import TemporaryDirectory

import gmsh

from scenes import load_scene, run_modes

SCENE = """
name = "pad on a disc, from a mesh file in millimetres"
[bodies.pad]
backend = "fe"
geometry = { shape = "mesh_file", file = "brake.msh", unit = "mm", part = "pad" }
material = { E = 1e10, nu = 0.3, rho = 2500.0 }
supports = [{ surface = "pad_back", components = ["x", "y"] }]
[bodies.disc]
backend = "fe"
geometry = { shape = "mesh_file", file = "brake.msh", unit = "mm", part = "disc" }
material = { E = 1.2e11, nu = 0.3, rho = 7200.0 }
supports = [{ surface = "bore" }]
[contacts.friction]
a = "pad.pad_face"
b = "disc.rubbing_face"
formulation = { method = "gpts", points = 5 }
p = 1e12
mu = 0.6
friction_direction_on_a = { circumferential_about = [0.0, 0.0, 1.0] }
[analysis]
kind = "cea"
max_frequency = 9000.0
"""


def write_mesh(file: Path, size: float = 14.0) -> None:
    """Write quadratic tetrahedra of a pad on a disc (mm), with named volumes and faces."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    ring = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 10, 100)
    bore = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 10, 40)
    ((_, disc),), _ = gmsh.model.occ.cut([(3, ring)], [(3, bore)])
    pad = gmsh.model.occ.addBox(60, -20, 10, 30, 40, 12)
    gmsh.model.occ.synchronize()
    for name, volume in (("disc", disc), ("pad", pad)):
        gmsh.model.addPhysicalGroup(3, [volume], name=name)
    faces = {
        "bore": _face(disc, 40, 40, 5),
        "rubbing_face": _face(disc, 100, 100, 10),
        "pad_face": _face(pad, 15, 20, 10),
        "pad_back": _face(pad, 15, 20, 22),
    }
    for name, face in faces.items():
        gmsh.model.addPhysicalGroup(2, [face], name=name)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(str(file))
    gmsh.finalize()


def _face(volume: int, x: float, y: float, z: float) -> int:
    """The face of a volume whose box has these half widths and this height in the middle."""
    for _, face in gmsh.model.getBoundary([(3, volume)], oriented=False):
        box = gmsh.model.occ.getBoundingBox(2, face)
        found = [(box[3] - box[0]) / 2, (box[4] - box[1]) / 2, (box[2] + box[5]) / 2]
        if all(abs(a - b) < 1e-3 for a, b in zip(found, (x, y, z), strict=True)):
            return face
    raise LookupError("no such face")


def frequencies(size: float = 14.0) -> list[float]:
    """Frequencies (Hz) of pad and disc from elements of a size (mm)."""
    with TemporaryDirectory() as folder:
        write_mesh(Path(folder) / "brake.msh", size)
        scene = Path(folder) / "brake.toml"
        scene.write_text(SCENE)  # the file of a mesh is looked for beside the scene
        result = run_modes(load_scene(scene))
        print(result)
        return sorted(result.frequencies.tolist())


if __name__ == "__main__":
    frequencies()
