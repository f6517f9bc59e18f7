"""Bad input for everything that reads: scenes, paths of `--set`, files, meshes, expressions."""

import json
import signal
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from mesh_writers import write
from scene_mutations import HOSTILE, NAMES, Bad, drawn, places, random_mutation, text_of, valid

from cea.errors import ConvergenceError, InputError
from cea.expressions import Expression
from cea.mesh import Mesh
from meshes.breaks import breaks_of
from meshes.mesh_file import MeshFile
from meshes.patches import NurbsFile
from meshes.shape_mesh import shape_mesh
from meshes.shapes import Box
from scenes import open_result
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene, read_scene

PATIENCE = 20.0
"""Seconds after which an input hangs; each takes milliseconds on a machine with nothing else."""
REFUSALS = (InputError, SceneError, ConvergenceError)
SETTINGS = [
    *("nan", "inf", "-1", "1e400", "[", "{", "{a=1}", "[[[]]]", "'", '"""', "1\nb=2", "true"),
    *("1979-05-27", "07:32:00", "[" * 3000, "9" * 5000, "x" * 5000, "\ud800", "", "\0"),
]
"""Values that a setting may be given."""


@contextmanager
def patience(seconds=PATIENCE):
    """Stop what hangs; a TimeoutError is no refusal."""

    def ring(*_):
        raise TimeoutError("hangs")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def faults_of(error):
    """The faults that a refusal tells."""
    return error.faults if isinstance(error, SceneError) else (error,)


def complaint(bad, read):
    """What is wrong with how an input was met, in words; None where all is well.

    A refusal is told in short lines that name a field. Anything else raised is a crash.
    """
    start = perf_counter()
    try:
        with patience():
            read(bad.value)
    except REFUSALS as error:
        lines = str(error).splitlines()
        if isinstance(error, InputError | SceneError):
            faults = faults_of(error)
            if not faults or not all(fault.field and fault.allowed for fault in faults):
                return f"{bad.words}: refused without a name: {error}"
            if bad.refused and bad.place and not _near(bad.place, faults):
                return f"{bad.words}: refused under another name: {lines[0]}"
            if len(lines) > 21 or max(map(len, lines)) > 2500:
                return f"{bad.words}: a refusal of {len(str(error))} characters"
        return None
    except Exception as error:
        return f"{bad.words}: {type(error).__name__}: {str(error)[:200]}"
    if bad.refused:
        return f"{bad.words}: accepted in {perf_counter() - start:.2f} s"
    return None


def _near(place, faults):
    """Whether some fault is told under the section that is wrong, or one of its own."""
    section = ".".join(map(str, place[:2]))
    return any(f.field.startswith((section, str(place[0]))) for f in faults)


ALPHABET = "xyzr 0123456789.+-*/()[]{},:;'\"\\_=<>&|~^%!@#$\n\0éｘ∞"


def random_expression(rng):
    """A hostile text, whole or cut and joined; or characters that are no expression."""
    if rng.random() < 0.5:
        first, second = str(drawn(rng, HOSTILE)), str(drawn(rng, HOSTILE))
        text = first if rng.random() < 0.5 else first[: rng.integers(1, 40)] + second
    else:
        text = "".join(drawn(rng, ALPHABET) for _ in range(rng.integers(1, 60)))
    return Bad("expression", f"expression {text[:60]!r}", text, True if text in HOSTILE else None)


def random_override(rng):
    """A setting of `--set` along a path that is there, broken or made up."""
    data = valid(str(rng.choice(NAMES)))
    parts = [str(key) for key in drawn(rng, list(places(data)))]
    for _ in range(rng.integers(0, 3)):
        where = int(rng.integers(len(parts) + 1))
        parts.insert(where, drawn(rng, ["", "0", "99", "-1", "x", "a b", "\0", "9" * 30, "é"]))
    value = drawn(rng, SETTINGS)
    return Bad("override", f"{'.'.join(parts)}={value[:20]}", (data["name"], parts, value), None)


def random_file(rng, whole):
    """Bytes of a file cut, changed, or mixed with others: a scene, or a stored result."""
    content = bytearray(whole)
    what = int(rng.integers(4))
    if what == 0:
        del content[int(rng.integers(len(content))) :]
    elif what == 1:
        for _ in range(int(rng.integers(1, 20))):
            content[int(rng.integers(len(content)))] = int(rng.integers(256))
    elif what == 2:
        start = int(rng.integers(len(content)))
        content[start : start + int(rng.integers(200))] = rng.bytes(int(rng.integers(200)))
    else:
        content = bytearray(rng.bytes(int(rng.integers(3000))))
    return bytes(content)


def a_mesh(rng):
    """Arrays of a valid mesh: a row of squares, or of cubes."""
    n = int(rng.integers(1, 4))
    if rng.random() < 0.5:
        x = np.array([[i, j] for i in range(n + 1) for j in (0, 1)], dtype=float)
        cells = [[2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3] for i in range(n)]
        return {"cell": "quadrilateral", "order": 1, "points": x.tolist(), "cells": cells} | {
            "surfaces": {"bottom": [[2 * i, 2 * i + 2] for i in range(n)], "left": [[0, 1]]}
        }
    x = np.array([[i, j, k] for i in range(n + 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    cells = [list(range(4 * i, 4 * i + 8)) for i in range(n)]
    return {"cell": "hexahedron", "order": 1, "points": x.tolist(), "cells": cells} | {
        "surfaces": {"bottom": [[4 * i, 4 * i + 2, 4 * i + 4, 4 * i + 6] for i in range(n)]}
    }


def random_mesh(rng):
    """A mesh with one thing wrong."""
    data = a_mesh(rng)
    part = str(rng.choice(["points", "cells", "cell", "order", "surfaces", "facets", "entry"]))
    name = next(iter(data["surfaces"]))
    refused = True
    if part == "entry":
        rows = drawn(rng, [data["points"], data["cells"], data["surfaces"][name]])
        row = drawn(rng, rows)
        wrong = [float("nan"), float("inf"), None, "1", [], {}, 1j, 10**400, True, -1e300]
        refused, wrong = (None, -1e300) if rng.random() < 0.05 else (True, drawn(rng, wrong[:-2]))
        row[int(rng.integers(len(row)))] = wrong
    elif part == "facets":
        facets = data["surfaces"][name]
        data["surfaces"][name] = drawn(rng, [[], facets * 2, [f[:-1] for f in facets], 3, None])
    elif part == "surfaces":
        data["surfaces"] = drawn(rng, [None, 3, [], "x", {1: [[0, 1]]}, {name: {}}])
        refused = data["surfaces"] != []
        refused = True if refused else None
    elif part == "cell":
        data["cell"] = drawn(rng, ["", "prism", None, 3, [], {}, "Hexahedron", b"hexahedron"])
    elif part == "order":
        data["order"] = drawn(rng, [0, -1, 5, 1.0, "1", None, 10**20, True, [1]])
    elif part == "cells":
        cells = data["cells"]
        wrong = [[], cells * 2, [c[:-1] for c in cells], [[c[0]] * len(c) for c in cells], None, 3]
        data["cells"] = drawn(rng, [*wrong, [cells], [[n + 1000 for n in c] for c in cells]])
    else:
        x = data["points"]
        data["points"] = drawn(rng, [[], None, "x", [[*p, 0.0] for p in x], [x], x[0], x[:-1]])
    return Bad("mesh", f"mesh with wrong {part}: {str(data)[:150]}", data, refused)


READERS = {".cdb": "mapdl_archive", ".xdmf": "h5py", ".vtu": "meshio"}
"""What reads files beside the project and gmsh."""


@cache
def whole_files():
    """Content and geometry of valid files of every format that can be read."""
    shape = Box((2.0, 1.0, 1.0))
    mesh = shape_mesh(shape, "hexahedron", 2, breaks=breaks_of(shape, (2, 1, 1)))
    names = ["a22.msh", "a.msh", "binary.msh", "a.inp", "a.cdb", "a.bdf", "a.xdmf", "a.vtu"]
    found = []
    with TemporaryDirectory() as folder:
        for name in names:
            file = Path(folder) / name
            if file.suffix not in READERS or find_spec(READERS[file.suffix]):
                geometry = write({"box": mesh}, file, lacking=True)["box"]
                found.append((file.suffix, file.read_bytes(), geometry))
        patch = {"degrees": [1, 1], "knot_vectors": [[0.0, 0.0, 1.0, 1.0]] * 2}
        patch["control_points"] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
        patches = json.dumps({"Base64Encoding": False, "SplineList": [patch]}).encode()
    return (*found, (".json", patches, {"shape": "nurbs_file", "unit": "m"}))


def random_mesh_file(rng):
    """A file of a mesh or of patches, cut, changed or mixed with another."""
    ending, whole, geometry = drawn(rng, whole_files())
    content = random_file(rng, whole)
    words = f"{ending} file {content[:40]!r} of {len(content)} bytes"
    return Bad("mesh file", words, (ending, content, geometry), None)


def reader(kind, folder):
    """What reads each kind of input; files go through a folder."""

    def override(value):
        name, parts, text = value
        return load_scene(name, [f"{'.'.join(parts)}={text}"])

    def scene_file(content):
        (folder / "scene.toml").write_bytes(content)
        return load_scene(folder / "scene.toml")

    def stored(content):
        (folder / "result.json").write_bytes(content)
        return open_result(folder / "result.json")

    def mesh_file(value):
        ending, content, geometry = value
        file = folder / f"bad{ending}"
        file.write_bytes(content)
        fields = {**geometry, "file": str(file)}
        if fields.pop("shape") == "nurbs_file":
            return NurbsFile(**fields)
        read = MeshFile(**fields)
        return read.mesh(read.faces)

    return {
        "scene": read_scene,
        "expression": lambda text: Expression(text)(np.full((3, 3), 0.4)),
        "override": override,
        "scene file": scene_file,
        "stored": stored,
        "mesh": lambda data: Mesh(**data),
        "mesh file": mesh_file,
    }[kind]


def random_bad(rng, stored):
    """One input of any kind.

    Parameters
    ----------
    rng
        Random numbers.
    stored
        Content of a stored result.
    """
    kind = float(rng.random())
    if kind < 0.5:
        return random_mutation(rng)
    if kind < 0.6:
        return random_expression(rng)
    if kind < 0.7:
        return random_override(rng)
    if kind < 0.8:
        whole = text_of(str(rng.choice(NAMES))).encode()
        content = random_file(rng, whole)
        return Bad("scene file", f"scene file {content[:40]!r}", content, None)
    if kind < 0.9:
        content = random_file(rng, stored)
        return Bad("stored", f"stored result {content[:40]!r}", content, None)
    return random_mesh(rng) if kind < 0.98 else random_mesh_file(rng)
