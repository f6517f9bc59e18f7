"""A thousand broken files: each is read or refused, none ends in a traceback or takes long."""

import time
from contextlib import suppress
from itertools import cycle

import numpy as np
import pytest
from mesh_writers import DECK, file_of, gmsh_wedges, mixed_file, two_boxes, write
from mpi4py import MPI

from cea.errors import InputError
from fe_cea.distribution import distribute
from meshes.files.reading import read_mesh_file
from meshes.mesh_file import MeshFile

SECONDS = 20
WORDS = b"-1 1e400 nan , * S4 = 0 GENERATE C3D6".split()


def originals(folder):
    """Small files of each format, and the set that is a body."""
    parts = {}
    for order in (1, 2):
        for name in (f"m{order}.inp", f"m{order}.cdb"):
            file = file_of(folder, name)
            mixed_file(file, order)
            parts[file] = None
        for ending in (".inp", ".cdb", "22.msh", "binary.msh", ".bdf", ".vtu", ".xdmf"):
            file = file_of(folder, f"a{order}{ending}")
            parts[file] = write(two_boxes("hexahedron", order), file, lacking=True)["left"]["part"]
    (folder / "parts.inp").write_text(DECK)
    gmsh_wedges(folder / "wedges.msh")
    return parts | {folder / "parts.inp": "Cube-2", folder / "wedges.msh": "body"}


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
    parts, read = originals(tmp_path), 0
    for k, (original, of_body) in zip(range(100), cycle(parts.items()), strict=False):
        file = tmp_path / f"broken{k}{original.suffix}"
        file.write_bytes(broken(original.read_bytes(), rng))
        start = time.perf_counter()
        with suppress(InputError):
            for name in read_mesh_file(file).names[:4]:
                body = MeshFile(str(file), "m", part=of_body, faces={"side": name})
                with suppress(InputError):
                    mesh = body.mesh(["side"])
                    body.nodes_left_out(["side"])
                    distribute(mesh, MPI.COMM_SELF, "mesh")
                    read += 1
        assert time.perf_counter() - start < SECONDS, file
    assert read > 20
