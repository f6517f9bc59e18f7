"""Bodies of several kinds of solid elements in files of other programs."""

import numpy as np

ABAQUS = {"hexahedron8": "C3D8I", "wedge6": "C3D6", "pyramid5": "C3D5", "tetrahedron4": "C3D4"}
ABAQUS |= {
    "hexahedron20": "C3D20R",
    "wedge15": "C3D15",
    "pyramid13": "C3D13",
    "tetrahedron10": "C3D10",
}
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


def listed(block):
    """Kind of a block, and its nodes as files list them."""
    return f"{block.cell}{block.nodes.shape[1]}", block.nodes


def abaqus_deck(file, points, blocks, low):
    """A deck with an element set of each cell, and a set of nodes."""
    lines = [
        "*NODE",
        *(f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(points.tolist(), 1)),
    ]
    count = 0
    for block in blocks:
        kind, nodes = listed(block)
        lines.append(f"*ELEMENT, TYPE={ABAQUS[kind]}, ELSET={block.cell.upper()}")
        for row in (nodes + 1).tolist():
            count += 1
            fields = [str(n) for n in (count, *row)]
            lines.append(", ".join(fields[:12]) + ("," if fields[12:] else ""))
            lines += [", ".join(fields[12:])] if fields[12:] else []
    lines += ["*NSET, NSET=LOW", *(str(n + 1) for n in low)]
    file.write_text("\n".join(lines) + "\n")


def ansys_archive(file, points, blocks, low):
    """An archive whose elements are all bricks of one type."""
    kinds = {f"{each.cell}": listed(each) for each in blocks}
    size = 8 if len(BRICKS[kinds["wedge"][0]]) == 8 else 20
    n = len(points)
    lines = [
        "/PREP7",
        f"ET, 1, {185 if size == 8 else 186}",
        f"NBLOCK,6,SOLID,{n},{n}",
        "(3i9,6e21.13e3)",
    ]
    for i, x in enumerate(points.tolist(), 1):
        lines.append(f"{i:9d}{0:9d}{0:9d}" + "".join(_fortran(value) for value in x))
    lines.append("N,R5.3,LOC,       -1,")
    rows = [
        np.array(row)[list(BRICKS[kind])] + 1 for kind, nodes in kinds.values() for row in nodes
    ]
    lines += [f"EBLOCK,19,SOLID,{len(rows)},{len(rows)}", "(19i9)"]
    for i, row in enumerate(rows, 1):
        numbers = [1, 1, 1, 1, 0, 0, 0, 0, size, 0, i, *row.tolist()]
        lines += ["".join(f"{k:9d}" for k in part) for part in (numbers[:19], numbers[19:]) if part]
    lines += [f"{-1:9d}", f"CMBLOCK,LOW     ,NODE,{len(low):8d}", "(8i10)"]
    lines += ["".join(f"{k + 1:10d}" for k in low[i : i + 8]) for i in range(0, len(low), 8)]
    file.write_text("\n".join([*lines, "FINISH"]) + "\n")


def _fortran(value):
    mantissa, exponent = f"{value:.13e}".split("e")
    return f"{mantissa}E{int(exponent):+04d}".rjust(21)


def vtu_file(file, points, blocks, low):
    """A file of VTK, as its own library writes it."""
    import pyvista

    types = {
        "hexahedron": (12, 25),
        "wedge": (13, 26),
        "pyramid": (14, 27),
        "tetrahedron": (10, 24),
    }
    cells = {types[b.cell][b.order - 1]: listed(b)[1] for b in blocks}
    grid = pyvista.UnstructuredGrid(cells, points)
    grid.point_data["LOW"] = np.isin(np.arange(len(points)), low).astype(int)
    grid.save(file)
