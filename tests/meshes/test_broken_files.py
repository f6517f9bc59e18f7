"""A thousand broken files: each is read or refused, none ends in a traceback or takes long."""

import time

import gmsh
import numpy as np
import pytest
from mesh_writers import file_of, mixed_file, two_boxes, write
from mpi4py import MPI

from cea.errors import InputError
from fe_cea.distribution import distribute
from meshes.mesh_file import MeshFile
from meshes.unstructured import gmsh_session

SECONDS = 20
TWO_PARTS = """*PART, NAME=a
*NODE, NSET=N
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=LOW, GENERATE
1, 4, 1
*SURFACE, NAME=S
E, S1
1, S2
*SURFACE, NAME=LOWER, COMBINE=DIFFERENCE
S, T
*SURFACE, NAME=T
E, S2
*END PART
*ASSEMBLY, NAME=b
*INSTANCE, NAME=a-1, PART=a
1, 0, 0
0, 0, 0, 0, 0, 1, 30
*END INSTANCE
*NSET, NSET=HELD
a-1.1, a-1.2, a-1.LOW
*NSET, NSET=ALL, ELSET=a-1.E
*ELSET, ELSET=WHOLE, INSTANCE=a-1
E
*END ASSEMBLY
"""


def originals(folder):
    """Small files of each format, with surfaces."""
    files = []
    for order in (1, 2):
        for name in (f"m{order}.inp", f"m{order}.cdb"):
            mixed_file(file_of(folder, name), order)
            files.append(folder / name)
        endings = (".inp", ".cdb", "22.msh", "binary.msh", ".bdf", ".vtu", ".xdmf")
        for name in (f"a{order}{ending}" for ending in endings):
            write(two_boxes("hexahedron", order), file_of(folder, name), lacking=True)
            files.append(folder / name)
    (folder / "parts.inp").write_text(TWO_PARTS)
    return [*files, folder / "parts.inp", wedges(folder / "wedges.msh")]


def wedges(file):
    with gmsh_session():
        base = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        sides = gmsh.model.occ.extrude([(2, base)], 0, 0, 1, [2], recombine=True)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [sides[1][1]], name="body")
        gmsh.model.addPhysicalGroup(2, [base], name="below")
        gmsh.option.setNumber("Mesh.MeshSizeMin", 1.0)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(file))
    return file


def broken(content, rng):
    """Content with bytes dropped or changed, or lines dropped, swapped or written twice."""
    for _ in range(rng.integers(1, 4)):
        lines = content.split(b"\n")
        i, j = rng.integers(len(lines), size=2)
        at, size = rng.integers(max(len(content), 1)), rng.integers(1, 20)
        match rng.integers(7):
            case 0:
                content = content[:at] + content[at + size :]
            case 1:
                content = content[:at] + rng.bytes(int(size)) + content[at + size :]
            case 2:
                lines[i], lines[j] = lines[j], lines[i]
                content = b"\n".join(lines)
            case 3:
                content = b"\n".join([*lines[:i], *lines[i + 1 :]])
            case 4:
                content = b"\n".join([*lines[:i], lines[j], *lines[i:]])
            case 5:
                content = content[:at] + b"%d" % rng.integers(-5, 10**9) + content[at + size :]
            case 6:
                words = [
                    b"-1",
                    b"1e400",
                    b"nan",
                    b",",
                    b"*",
                    b"S4",
                    b"=",
                    b"0",
                    b"GENERATE",
                    b"C3D6",
                ]
                content = content[:at] + words[rng.integers(len(words))] + content[at:]
    return content


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_broken_files_are_read_or_refused(tmp_path, part):
    rng = np.random.default_rng(part)
    files, read = originals(tmp_path), 0
    for k in range(100):
        original = files[k % len(files)]
        file = tmp_path / f"broken{k}{original.suffix}"
        file.write_bytes(broken(original.read_bytes(), rng))
        start = time.perf_counter()
        try:
            body = MeshFile(str(file), "m")
            for name in body.surfaces[:4]:
                try:
                    mesh = body.mesh([name])
                    body.nodes_left_out([name])
                except InputError:
                    continue
                distribute(mesh, MPI.COMM_SELF, "mesh")
                read += 1
        except InputError:
            pass
        assert time.perf_counter() - start < SECONDS, file
    assert read > 0
