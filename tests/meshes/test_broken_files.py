"""A thousand broken files: each is read or refused, none ends in a traceback or takes long."""

import time

import numpy as np
import pytest
from mesh_writers import DECK, file_of, gmsh_wedges, mixed_file, two_boxes, write
from mpi4py import MPI

from cea.errors import InputError
from fe_cea.distribution import distribute
from meshes.mesh_file import MeshFile

SECONDS = 20
WORDS = b"-1 1e400 nan , * S4 = 0 GENERATE C3D6".split()


def originals(folder):
    """Small files of each format, with surfaces."""
    files = []
    for order in (1, 2):
        for name in (f"m{order}.inp", f"m{order}.cdb"):
            files.append(file_of(folder, name))
            mixed_file(files[-1], order)
        for ending in (".inp", ".cdb", "22.msh", "binary.msh", ".bdf", ".vtu", ".xdmf"):
            files.append(file_of(folder, f"a{order}{ending}"))
            write(two_boxes("hexahedron", order), files[-1], lacking=True)
    (folder / "parts.inp").write_text(DECK)
    gmsh_wedges(folder / "wedges.msh")
    return [*files, folder / "parts.inp", folder / "wedges.msh"]


def broken(content, rng):
    """Content with bytes dropped or changed, or lines dropped, swapped or written twice."""
    for _ in range(rng.integers(1, 4)):
        lines = content.split(b"\n")
        i, j = rng.integers(len(lines), size=2)
        at, size = rng.integers(max(len(content), 1)), rng.integers(1, 20)
        before, after = content[:at], content[at + size :]
        swapped = [*lines]
        swapped[i], swapped[j] = lines[j], lines[i]
        ways = (
            before + after,
            before + rng.bytes(int(size)) + after,
            b"\n".join(swapped),
            b"\n".join([*lines[:i], *lines[i + 1 :]]),
            b"\n".join([*lines[:i], lines[j], *lines[i:]]),
            before + b"%d" % rng.integers(-5, 10**9) + after,
            before + WORDS[rng.integers(len(WORDS))] + content[at:],
        )
        content = ways[rng.integers(len(ways))]
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
