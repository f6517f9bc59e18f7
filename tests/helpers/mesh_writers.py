"""Two meshes written to one file of every format, by other programs where there are some."""

import gmsh
import meshio
import numpy as np

from cea.mesh import DIMENSION, Mesh, lattice
from meshes.files.elements import KINDS
from meshes.unstructured import gmsh_session

MESHIO = {
    "quadrilateral4": "quad", "quadrilateral8": "quad8", "quadrilateral9": "quad9",
    "triangle3": "triangle", "triangle6": "triangle6",
    "tetrahedron4": "tetra", "tetrahedron10": "tetra10",
    "hexahedron8": "hexahedron", "hexahedron20": "hexahedron20", "hexahedron27": "hexahedron27",
}  # fmt: skip
FACETS = {"tetrahedron": "triangle", "hexahedron": "quadrilateral"}
ABAQUS = {"tetrahedron4": "C3D4", "tetrahedron10": "C3D10", "hexahedron8": "C3D8R"}
ABAQUS |= {"hexahedron20": "C3D20R"}
ANSYS = {"tetrahedron4": 285, "tetrahedron10": 187, "hexahedron8": 185, "hexahedron20": 186}
LACKING = {("hexahedron", 2): 20, ("quadrilateral", 2): 8}
"""Nodes of kinds that have no middle nodes, as most programs write them."""


class Written:
    """Meshes of named bodies as cells and facets in the order of other programs.

    Parameters
    ----------
    meshes
        Meshes by name of the body.
    lacking
        Whether hexahedra of order 2 have 20 nodes.
    """

    def __init__(self, meshes: dict[str, Mesh], lacking: bool):
        starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes.values())])
        self.points = np.concatenate([mesh.points for mesh in meshes.values()])
        self.solids, self.facets = {}, {}
        for (name, mesh), start in zip(meshes.items(), starts, strict=False):
            self.kind, order = listed(mesh.cell, mesh.order, lacking)
            self.solids[name] = start + mesh.cells[:, order]
            if mesh.cell in FACETS:
                self.facet_kind, order = listed(FACETS[mesh.cell], mesh.order, lacking)
                for side, facets in mesh.surfaces.items():
                    self.facets[f"{name}_{side}"] = start + facets[:, order]
        if lacking:
            self._without_loose()

    def _without_loose(self):
        used = np.unique(np.concatenate([nodes.ravel() for nodes in self.solids.values()]))
        number = np.full(len(self.points), -1)
        number[used] = np.arange(len(used))
        self.points = self.points[used]
        self.solids = {name: number[nodes] for name, nodes in self.solids.items()}
        self.facets = {name: number[nodes] for name, nodes in self.facets.items()}

    def marked(self, facet):
        """Ones at the nodes of a named facet, zeros elsewhere."""
        marks = np.zeros(len(self.points), dtype=int)
        marks[np.unique(self.facets[facet])] = 1
        return marks


def listed(cell, order, lacking):
    """Kind of a cell and the order in which other programs list its nodes."""
    kinds = {name: kind for name, kind in KINDS.items() if (kind.cell, kind.order) == (cell, order)}
    count = LACKING.get((cell, order)) if lacking else None
    name = f"{cell}{count}" if count else max(kinds, key=lambda k: len(kinds[k].reference))
    ours = lattice(DIMENSION[cell], order, cell in ("triangle", "tetrahedron")) / order
    apart = np.linalg.norm(kinds[name].reference[:, None] - ours, axis=2)
    return name, apart.argmin(axis=1)


def write(meshes, file, lacking=False):
    """Write meshes of named bodies to a file; its ending tells the format.

    Returns the geometry of each body as a scene has it, surfaces by their names in the mesh.
    """
    written = Written(meshes, lacking)
    ending = file.suffix
    WRITERS[ending](written, file)
    return {name: geometry(written, name, mesh, file) for name, mesh in meshes.items()}


def geometry(written, name, mesh, file):
    """A body of a file as a scene has it."""
    numbers = {each: i for i, each in enumerate([*written.solids, *written.facets], 1)}
    words = {".bdf": ("PSOLID {}", "PSHELL {}"), ".vtu": ("group {}",) * 2}
    words[".nas"] = words[".bdf"]
    words[".xdmf"] = ("group {}", None)
    solid, facet = words.get(file.suffix, (None, None))
    sets = {side: f"{name}_{side}" for side in mesh.surfaces}
    if facet:
        sets = {side: facet.format(numbers[each]) for side, each in sets.items()}
    if file.suffix == ".cdb":
        sets = {side: each.upper() for side, each in sets.items()}
        name = name.upper()
    part = solid.format(numbers[name]) if solid else name
    data = {"shape": "mesh_file", "file": str(file), "unit": "m", "part": part}
    return data | {"faces": sets}


def write_meshio(written, file, **options):
    solids, facets = written.solids.values(), written.facets.values()
    fields = {".bdf": "nastran:ref", ".nas": "nastran:ref", ".msh": "gmsh:physical"}
    field = fields.get(file.suffix, "group")
    numbers = range(1, 1 + len(written.solids) + len(written.facets))
    groups = [np.full(len(x), i) for i, x in zip(numbers, (*solids, *facets), strict=True)]
    cells = [(MESHIO[written.kind], nodes) for nodes in solids]
    names, marks, data = {}, {}, {}
    if file.suffix == ".xdmf":
        # Of files with blocks of several kinds, meshio reads back those of order 1 alone.
        cells = [(cells[0][0], np.concatenate(list(solids)))]
        groups = [np.concatenate(groups[: len(solids)])]
        marks = {name: written.marked(name) for name in written.facets}
    else:
        cells += [(MESHIO[written.facet_kind], nodes) for nodes in facets]
    data[field] = groups
    if file.suffix == ".msh":
        data["gmsh:geometrical"] = groups
        dims = [3] * len(solids) + [2] * len(facets)
        every = zip([*written.solids, *written.facets], numbers, dims, strict=True)
        names = {name: np.array([number, dim]) for name, number, dim in every}
    meshio.write(file, meshio.Mesh(written.points, cells, marks, data, names), **options)


def write_gmsh(written, file):
    """Version 2.2 as meshio writes it; gmsh makes 4.1 of it, binary where the name says so."""
    write_meshio(written, file, file_format="gmsh22", binary=False)
    if "22" not in file.stem:
        with gmsh_session():
            gmsh.merge(str(file))
            gmsh.option.setNumber("Mesh.Binary", "binary" in file.stem)
            gmsh.write(str(file))


def write_abaqus(written, file):
    """A deck: surfaces of one body by element faces, those of the others as sets of nodes."""
    lines = ["*HEADING", "a pair of bodies", "** nodes", "*NODE"]
    lines += [f"{i}, " + ", ".join(map(repr, x)) for i, x in enumerate(written.points.tolist(), 1)]
    count = 0
    for name, nodes in written.solids.items():
        lines.append(f"*Element, type={ABAQUS[written.kind]}, elset={name}")
        for row in nodes.tolist():
            count += 1
            listed_nodes = [str(node + 1) for node in row]
            lines.append(f"{count}, " + ", ".join(listed_nodes[:10]) + ("," if row[10:] else ""))
            if row[10:]:
                lines.append(", ".join(listed_nodes[10:]))
    for name, nodes in written.facets.items():
        lines.append(f"*NSET, NSET={name}")
        rows = (np.unique(nodes) + 1).tolist()
        lines += [", ".join(map(str, rows[i : i + 16])) for i in range(0, len(rows), 16)]
    file.write_text("\n".join(lines) + "\n*STEP\n*FREQUENCY\n10\n*END STEP\n")


def write_ansys(written, file):
    """An archive as CDWRITE makes it."""
    n = len(written.points)
    lines = ["/PREP7", f"ET, 1, {ANSYS[written.kind]}", f"NBLOCK,6,SOLID,{n},{n}"]
    lines.append("(3i9,6e21.13e3)")
    for i, x in enumerate(written.points.tolist(), 1):
        lines.append(f"{i:9d}{0:9d}{0:9d}" + "".join(_fortran(value) for value in x))
    lines.append("N,R5.3,LOC,       -1,")
    solids = [(m, row) for m, rows in enumerate(written.solids.values(), 1) for row in rows + 1]
    lines += [f"EBLOCK,19,SOLID,{len(solids)},{len(solids)}", "(19i9)"]
    for i, (material, row) in enumerate(solids, 1):
        head = [material, 1, 1, 1, 0, 0, 0, 0, len(row), 0, i]
        numbers = [*head, *row.tolist()]
        lines += ["".join(f"{k:9d}" for k in part) for part in (numbers[:19], numbers[19:]) if part]
    lines.append(f"{-1:9d}")
    first = 1
    for name, nodes in written.solids.items():
        lines += _component(name, "ELEM", np.arange(first, first + len(nodes)))
        first += len(nodes)
    for name, nodes in written.facets.items():
        lines += _component(name, "NODE", np.unique(nodes) + 1)
    file.write_text("\n".join(lines) + "\nFINISH\n")


def _fortran(value):
    mantissa, exponent = f"{value:.13e}".split("e")
    return f"{mantissa}E{int(exponent):+04d}".rjust(21)


def _component(name, kind, numbers):
    items = numbers.tolist()
    lines = [f"CMBLOCK,{name.upper():<8},{kind},{len(items):8d}  ! component", "(8i10)"]
    return lines + ["".join(f"{k:10d}" for k in items[i : i + 8]) for i in range(0, len(items), 8)]


WRITERS = {
    ".msh": write_gmsh,
    ".inp": write_abaqus,
    ".cdb": write_ansys,
    ".bdf": write_meshio,
    ".nas": lambda written, file: write_meshio(written, file, file_format="nastran"),
    ".xdmf": lambda written, file: write_meshio(written, file, data_format="XML"),
    ".vtu": write_meshio,
}
