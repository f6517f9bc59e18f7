"""Mesh files of every format, by other programs where there are some: boxes, mixed elements."""

from itertools import product
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from cea.mesh import DIMENSION, Mesh, lattice
from meshes.breaks import breaks_of
from meshes.files.content import block
from meshes.files.elements import KINDS
from meshes.mesh_file import MeshFile
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box
from meshes.unstructured import gmsh_session

NEEDED = {".cdb": "mapdl_archive", ".xdmf": "h5py", ".vtu": "meshio"}
FACETS = {"tetrahedron": "triangle", "hexahedron": "quadrilateral"}
BRICKS = {
    "hexahedron8": range(8),
    "wedge6": [0, 1, 2, 2, 3, 4, 5, 5],
    "pyramid5": [0, 1, 2, 3, 4, 4, 4, 4],
    "tetrahedron4": [0, 1, 2, 2, 3, 3, 3, 3],
    "hexahedron20": range(20),
    "wedge15": [0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14],
    "pyramid13": [0, 1, 2, 3, 4, 4, 4, 4, 5, 6, 7, 8, 4, 4, 4, 4, 9, 10, 11, 12],
    "tetrahedron10": [0, 1, 2, 2, 3, 3, 3, 3, 4, 5, 2, 6, 3, 3, 3, 3, 7, 8, 9, 9],
}
"""Nodes of elements as bricks (SOLID185, SOLID186) whose nodes fall on one another."""


def file_of(folder, name):
    """A file to write, where what reads its format is there."""
    file = folder / name
    if file.suffix in NEEDED:
        pytest.importorskip(NEEDED[file.suffix])
    return file


def rows_of(fields, most):
    """Fields over lines, all but the last of which end with a comma."""
    parts = [fields[i : i + most] for i in range(0, len(fields), most)]
    return ",\n".join(", ".join(map(str, part)) for part in parts)


def abaqus_deck(points, solids, node_sets):
    """A deck of element sets, (name, kind, nodes from 0), a name once or more, and node sets."""
    lines = ["*NODE, NSET=ALL"]
    lines += [rows_of([i, *x], 4) for i, x in enumerate(points.tolist(), 1)]
    count = 0
    for name, _, nodes in solids:
        lines.append(f"*Element, type=C3D{nodes.shape[1]}, elset={name}")
        lines += [rows_of([count + i, *row], 11) for i, row in enumerate((nodes + 1).tolist(), 1)]
        count += len(nodes)
    for name, nodes in node_sets.items():
        lines += [f"*NSET, NSET={name}", *map(str, (np.unique(nodes) + 1).tolist())]
    return "\n".join(lines) + "\n"


def ansys_archive(points, solids, node_sets, element):
    """An archive as CDWRITE makes it, all elements of one type; as 185 and 186 they are bricks."""
    n = len(points)
    lines = ["/PREP7", f"ET, 1, {element}", f"NBLOCK,6,SOLID,{n},{n}", "(3i9,6e21.13e3)"]
    for i, x in enumerate(points.tolist(), 1):
        lines.append(f"{i:9d}{0:9d}{0:9d}" + "".join(map(_fortran, x)))
    rows, sets = [], []
    for name, (kind, nodes) in solids.items():
        sets += _component(name, "ELEM", len(rows) + 1 + np.arange(len(nodes)))
        rows += (nodes[:, list(BRICKS[kind])] if element in (185, 186) else nodes).tolist()
    lines += ["N,R5.3,LOC,       -1,", f"EBLOCK,19,SOLID,{len(rows)},{len(rows)}", "(19i9)"]
    for i, row in enumerate(rows, 1):
        numbers = [1, 1, 1, 1, 0, 0, 0, 0, len(row), 0, i, *(node + 1 for node in row)]
        lines += ["".join(f"{k:9d}" for k in part) for part in (numbers[:19], numbers[19:]) if part]
    for name, nodes in node_sets.items():
        sets += _component(name, "NODE", np.unique(nodes) + 1)
    return "\n".join([*lines, f"{-1:9d}", *sets, "FINISH"]) + "\n"


def _fortran(value):
    mantissa, exponent = f"{value:.13e}".split("e")
    return f"{mantissa}E{int(exponent):+04d}".rjust(21)


def _component(name, kind, numbers):
    lines = [f"CMBLOCK,{name.upper():<8},{kind},{len(numbers):8d}  ! component", "(8i10)"]
    parts = np.split(numbers, range(8, len(numbers), 8))
    return lines + ["".join(f"{k:10d}" for k in part) for part in parts]


def write_sets(file, points, solids, node_sets, element=None):
    """A deck, or an archive of a type of elements, whose components are the sets."""
    if file.suffix == ".inp":
        every = [(name, *of_kind) for name, of_kind in solids.items()]
        file.write_text(abaqus_deck(points, every, node_sets))
        return
    own = {"tetrahedron4": 285, "tetrahedron10": 187, "hexahedron20": 186}
    kind, _ = next(iter(solids.values()))
    file.write_text(ansys_archive(points, solids, node_sets, element or own.get(kind, 185)))


def of_meshio(kind):
    """Its name of a kind."""
    short = {"triangle3": "triangle", "tetrahedron4": "tetra", "quadrilateral4": "quad"}
    short["hexahedron8"] = "hexahedron"
    return short.get(kind, kind.replace("tetrahedron", "tetra").replace("quadrilateral", "quad"))


def meshio_file(file, points, solids, facets, **options):
    """A file that meshio writes, sets as numbers from 1 on cells; in .xdmf facets mark nodes."""
    fields = {".bdf": "nastran:ref", ".nas": "nastran:ref", ".msh": "gmsh:physical"}
    every = list((solids | ({} if file.suffix == ".xdmf" else facets)).values())
    cells = [(of_meshio(kind), nodes) for kind, nodes in every]
    groups = [np.full(len(nodes), i) for i, (_, nodes) in enumerate(cells, 1)]
    names, marks, data = {}, {}, {}
    if file.suffix == ".xdmf":
        # Of files with blocks of several kinds, meshio reads back those of order 1 alone.
        cells = [(cells[0][0], np.concatenate([nodes for _, nodes in cells]))]
        groups = [np.concatenate(groups)]
        at = np.arange(len(points))
        marks = {name: np.isin(at, nodes).astype(int) for name, (_, nodes) in facets.items()}
    data[fields.get(file.suffix, "group")] = groups
    if file.suffix == ".msh":
        data["gmsh:geometrical"] = groups
        dims = [3] * len(solids) + [2] * len(facets)
        named = enumerate(zip([*solids, *facets], dims, strict=True), 1)
        names = {name: np.array([number, dim]) for number, (name, dim) in named}
    meshio.write(file, meshio.Mesh(points, cells, marks, data, names), **options)


def gmsh_file(file, *model):
    """Version 2.2 as meshio writes it; gmsh makes 4.1 of it, binary where the name says so."""
    meshio_file(file, *model, file_format="gmsh22", binary=False)
    if "22" not in file.stem:
        with gmsh_session():
            gmsh.merge(str(file))
            gmsh.option.setNumber("Mesh.Binary", "binary" in file.stem)
            gmsh.write(str(file))


def gmsh_model_file(file, order=1, version=4.1):
    """Write the model of the session, meshed with elements of size one."""
    gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1.0)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.write(str(file))
    return str(file)


def gmsh_boxes(file, count=1, *, shared=False, **how):
    """Unit boxes along x: groups of each and of faces by the x of their middle; ``whole``."""
    with gmsh_session():
        occ = gmsh.model.occ
        boxes = [(3, occ.addBox(x, 0, 0, 1, 1, 1)) for x in range(count)]
        if shared:
            occ.fragment(boxes[:1], boxes[1:])
        occ.synchronize()
        for dim, word in ((3, "box"), (2, "face")):
            for _, tag in gmsh.model.getEntities(dim):
                name = f"{word} {occ.getCenterOfMass(dim, tag)[0]:.1f}"
                gmsh.model.addPhysicalGroup(dim, [tag], name=name)
        if shared:
            gmsh.model.addPhysicalGroup(3, [tag for _, tag in boxes], name="whole")
        return gmsh_model_file(file, **how)


def gmsh_wedges(file, **how):
    """A unit cube of two layers of wedges, its lower face a group ``below``."""
    with gmsh_session():
        base = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        sides = gmsh.model.occ.extrude([(2, base)], 0, 0, 1, [2], recombine=True)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [sides[1][1]], name="body")
        gmsh.model.addPhysicalGroup(2, [base], name="below")
        return gmsh_model_file(file, **how)


DECK = (Path(__file__).parents[1] / "data" / "two_cubes.inp").read_text()
"""A deck of Abaqus with parts, instances and all ways to name sets."""


def listed(cell, order, lacking):
    """Kind of a cell and the order in which other programs list its nodes.

    With ``lacking``, cells of order 2 have no nodes in the middle of faces and cells.
    """
    counts = sorted(len(k.groups) for k in KINDS.values() if (k.cell, k.order) == (cell, order))
    name = f"{cell}{counts[0 if lacking else -1]}"
    ours = lattice(DIMENSION[cell], order, cell in ("triangle", "tetrahedron")) / order
    apart = np.linalg.norm(KINDS[name].reference[:, None] - ours, axis=2)
    return name, apart.argmin(axis=1)


def write(meshes, file, lacking=False, element=None):
    """Write meshes of named bodies to one file; its ending tells the format.

    Returns the geometry of each body as a scene has it, surfaces by their names in the mesh.
    """
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes.values())])
    points = np.concatenate([mesh.points for mesh in meshes.values()])
    solids, facets = {}, {}
    for (name, mesh), start in zip(meshes.items(), starts, strict=False):
        kind, order = listed(mesh.cell, mesh.order, lacking)
        solids[name] = kind, start + mesh.cells[:, order]
        kind, order = listed(FACETS[mesh.cell], mesh.order, lacking)
        for side, nodes in mesh.surfaces.items():
            facets[f"{name}_{side}"] = kind, start + nodes[:, order]
    used = np.unique(np.concatenate([nodes.ravel() for _, nodes in solids.values()]))
    points = points[used]
    solids, facets = (
        {name: (kind, np.searchsorted(used, nodes)) for name, (kind, nodes) in each.items()}
        for each in (solids, facets)
    )
    ending, options = file.suffix, {".nas": {"file_format": "nastran"}}
    options[".xdmf"] = {"data_format": "XML"}
    if ending in (".inp", ".cdb"):
        sides = {name: nodes for name, (_, nodes) in facets.items()}
        write_sets(file, points, solids, sides, element)
    elif ending == ".msh":
        gmsh_file(file, points, solids, facets)
    else:
        meshio_file(file, points, solids, facets, **options.get(ending, {}))
    words = {".bdf": ("PSOLID {}", "PSHELL {}"), ".nas": ("PSOLID {}", "PSHELL {}")}
    words |= {".vtu": ("group {}",) * 2, ".xdmf": ("group {}", None)}
    solid, facet = words.get(ending, (None, None))
    numbers = {each: i for i, each in enumerate([*solids, *facets], 1)}

    def called(name, word):
        shown = word.format(numbers[name]) if word else name
        return shown.upper() if ending == ".cdb" else shown

    return {
        name: {
            "shape": "mesh_file",
            "file": str(file),
            "unit": "m",
            "part": called(name, solid),
            "faces": {side: called(f"{name}_{side}", facet) for side in mesh.surfaces},
        }
        for name, mesh in meshes.items()
    }


def two_boxes(cell, order, elements=(2, 1, 3)):
    """Bent meshes of two boxes that do not touch.

    By a quadratic map, which 20-node hexahedra hold exactly, in any order of nodes but theirs not.
    """
    shapes = {"left": Box((1.0, 0.5, 1.5)), "right": Box((1.0, 0.5, 1.5), (2.0, 0.25, 0.0))}
    meshes = {}
    for name, shape in shapes.items():
        flat = shape_mesh(shape, cell, order, breaks=breaks_of(shape, elements))
        x, y, z = flat.points.T
        bent = [x + 0.1 * y * z, 1 + y + 0.08 * x * x - 0.05 * z, z + 0.06 * x * y]
        meshes[name] = Mesh(cell, order, np.stack(bent, axis=1), flat.cells, flat.surfaces)
    return meshes


def made(data, **changes):
    return MeshFile(**{**data, **changes})


def by_place(points):
    """Rows in the order of their coordinates."""
    return points[np.lexsort(np.round(points, 9).T)]


CUBE = KINDS["hexahedron8"].reference.astype(int)
WEDGES = [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)]
PYRAMIDS = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]


def mixed_cells(elements=(3, 2, 3)):
    """Corners of elements by cell, as points of a lattice of even numbers from 0."""
    cells = {"hexahedron": [], "wedge": [], "pyramid": [], "tetrahedron": []}
    for place in product(*map(range, elements)):
        at = CUBE * 4 + 4 * np.array(place)
        kind = (place[0] + place[2]) % 3  # whole columns along y, so that wedges match
        if kind == 0:
            cells["hexahedron"].append(at)
        elif kind == 1:
            turned = 4 * (CUBE[:, [1, 2, 0]] + np.array(place))  # wedges along y
            cells["wedge"] += [turned[list(wedge)] for wedge in WEDGES]
        else:
            middle = at.mean(axis=0).astype(int)
            cells["pyramid"] += [np.vstack([at[list(face)], middle]) for face in PYRAMIDS]
    # a pyramid becomes two tetrahedra where its base lies on the boundary
    low = [p for p in cells["pyramid"] if (p[:4, 1] == 0).all()]
    cells["pyramid"] = [p for p in cells["pyramid"] if not (p[:4, 1] == 0).all()]
    cells["tetrahedron"] += [p[list(t)] for p in low for t in ((0, 1, 2, 4), (0, 2, 3, 4))]
    return {cell: np.array(corners) for cell, corners in cells.items()}


def mixed_blocks(counts, seed=0, move=lambda x: x):
    """Points, moved, and blocks of elements of some nodes, which are numbered at random."""
    kinds = dict(zip(("hexahedron", "wedge", "pyramid", "tetrahedron"), counts, strict=True))
    places = {
        cell: np.stack([at[:, list(group)].mean(axis=1) for group in
                        KINDS[f"{cell}{kinds[cell]}"].groups], axis=1)
        for cell, at in mixed_cells().items()
    }  # fmt: skip
    every = np.concatenate([at.reshape(-1, 3) for at in places.values()])
    points, rows = np.unique(every, axis=0, return_inverse=True)
    number = np.random.default_rng(seed).permutation(len(points))
    moved = np.empty_like(points)
    moved[number] = move(points / 4)
    ends = np.cumsum([at.shape[0] * at.shape[1] for at in places.values()])[:-1]
    blocks = []
    for (cell, at), own in zip(places.items(), np.split(number[rows.ravel()], ends), strict=True):
        nodes_of = own.reshape(at.shape[:2])
        blocks.append(block(cell, f"{cell}{kinds[cell]}", np.arange(len(at)) + 1, nodes_of))
    return moved, blocks


def mixed_file(file, order, element=None):
    """A file of mixed elements, a set of each cell, and the nodes on y = 0 as the set LOW."""
    points, blocks = mixed_blocks((8, 6, 5, 4) if order == 1 else (20, 15, 13, 10))
    solids = {b.cell.upper(): (f"{b.cell}{b.nodes.shape[1]}", b.nodes) for b in blocks}
    low = {"LOW": np.flatnonzero(points[:, 1] == 0)}
    write_sets(file, points, solids, low, element)
    return points, blocks
