"""Bad input for everything that reads: scenes, paths of `--set`, files, meshes, expressions.

A mutation is a valid scene with one thing wrong, and whether it must be refused: True where the
value is bad whatever the rest says, None where it may be right.
"""

import json
import signal
import tomllib
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np

from cea.errors import ConvergenceError, InputError
from cea.fields import Expression
from cea.mesh import Mesh
from scenes.opened import open_result
from scenes.read import SCENES, SceneError, load_scene, read_scene

PATIENCE = 20.0
"""Seconds after which an input hangs; each takes milliseconds on a machine with nothing else."""
REFUSALS = (InputError, SceneError, ConvergenceError)
NAMES = sorted(file.stem for file in SCENES.glob("*.toml"))
POSITIVE = {
    *("E", "rho", "P", "p", "max_frequency", "inner_radius", "outer_radius", "degree", "elements"),
    *("size", "points", "samples"),
}
"""Fields whose numbers are greater than zero."""
NOT_NEGATIVE = POSITIVE | {"mu", "growth_threshold", "pictures", "paraview"}
REQUIRED = {
    *("backend", "geometry", "material", "mesh", "E", "nu", "shape", "a", "b", "formulation"),
    *("name", "bodies", "analysis", "kind", "max_frequency", "method", "surface", "pressure"),
    *("inner_radius", "outer_radius", "bottom", "top", "start", "end", "vector"),
    "circumferential_about",
}
FREE_TEXT = {"name", "description"}
NAMED = {"bodies", "contacts", "through", "faces"}
"""Tables whose names are free."""
OF_SPACE = {"vector", "elements", "degree", "origin", "axis", "circumferential_about"}
"""Lists as long as space has dimensions, or as three."""
HOSTILE = [
    "__import__('os').system('touch stolen')",
    "().__class__.__bases__[0].__subclasses__()",
    "x.__class__.__mro__[1].__subclasses__()",
    "x.tofile('stolen')",
    "open('/etc/passwd').read()",
    "sin.__globals__",
    "(lambda: 1)()",
    "[y for y in x]",
    "{z: 1 for z in x}",
    "exec('1')",
    "eval('1')",
    "10**10**10",
    "9**9**9**9",
    "'a'*10**10",
    "[0]*10**10",
    "(" * 500 + "x" + ")" * 500,
    "-" * 1500 + "x",
    "x+" * 900 + "x",
    "x" * 100_000,
    "sin(x, y)",
    "where(x > 0)",
    "sin(x, out=y)",
    "maximum(x, y, z)",
    "f'{x.__class__}'",
    "x if x else y",
    "x := 3",
    "x = 3",
    "import os",
    "x; y",
    "print(x)",
    "1j",
    "True",
    "None",
    "...",
    "x[0]",
    "x @ y",
    "1 << 100000",
    "\0",
    "",
    "nan",
    "inf",
    "1e999",
    "\ud800",
    "ｘ.real",
    "x.real",
]
"""Texts that are no expression: they run code, climb out, or ask for more than there is."""


SETTINGS = [
    *("nan", "inf", "-1", "1e400", "[", "{", "{a=1}", "[[[]]]", "'", '"""', "1\nb=2", "true"),
    *("1979-05-27", "07:32:00", "[" * 3000, "9" * 5000, "x" * 5000, "\ud800", "", "\0"),
]
"""Values that a setting may be given."""


@dataclass(frozen=True)
class Bad:
    """An input: what reads it, what it is in words, and whether it must be refused."""

    kind: str
    words: str
    value: Any
    refused: bool | None
    place: tuple[Any, ...] = ()


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


@cache
def _text_of(name):
    return (SCENES / f"{name}.toml").read_text()


def valid(name, backend="iga"):
    """A scene that comes with the project, as plain data, all bodies on one backend."""
    data = tomllib.loads(_text_of(name))
    for body in data["bodies"].values():
        body["backend"] = backend
    return data


def places(value, path=()):
    """Every place of nested data but the root."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in items:
        yield (*path, key)
        if isinstance(part, dict | list):
            yield from places(part, (*path, key))


def at(data, path):
    for key in path:
        data = data[key]
    return data


def replaced(data, path, value):
    """A copy with another value at a place."""
    copy = deepcopy(data)
    at(copy, path[:-1])[path[-1]] = value
    return copy


def removed(data, path):
    copy = deepcopy(data)
    del at(copy, path[:-1])[path[-1]]
    return copy


def field_of(path):
    """The name of the field that a place belongs to."""
    return next((key for key in reversed(path) if isinstance(key, str)), "")


def used(data, path):
    """Whether the run reads the place: the mesh of the other backend is only looked through."""
    return not ("mesh" in path and len(path) > 3 and path[3] != data["bodies"][path[1]]["backend"])


def mutations(data):
    """Every mutation of a valid scene, field by field."""
    for path in places(data):
        value, field = at(data, path), field_of(path)
        for words, new, refused in _changes(value, field, path):
            if refused and not used(data, path) and words not in _ALWAYS:
                refused = None
            told = f"{'.'.join(map(str, path))} {words}"
            yield Bad("scene", told, replaced(data, path, new), refused, path)
        if isinstance(path[-1], str):
            must = path[-1] in REQUIRED or None
            yield Bad("scene", f"{'.'.join(path_text(path))} missing", removed(data, path), must)


def path_text(path):
    return map(str, path)


_ALWAYS = {"not a number", "huge", "wrong type", "extra field", "infinite"}


def _changes(value, field, path):
    """New values of a place, each with its name and whether it must be refused."""
    if isinstance(value, bool):
        yield from ((f"{new!r} for a truth value", new, True) for new in ("yes", 1, [], {}))
    elif isinstance(value, int | float):
        yield from _number_changes(value, field, path)
    elif isinstance(value, str):
        yield from _text_changes(value, field)
    elif isinstance(value, list):
        yield from _list_changes(value, field)
    else:
        yield from _table_changes(value, field, path)


def _number_changes(value, field, path):
    for new in ("text", [], {}, [value], {"value": value}, True):
        yield "wrong type", new, True
    yield "none", None, field not in ("P", "p", "growth_threshold", "rho") or None
    yield "not a number", float("nan"), True
    for new in (float("inf"), -float("inf")):
        yield "infinite", new, True
    for new in (1e300, -1e300, 10**400):
        yield "huge", new, True
    yield "next to nothing", 1e-300, (field in POSITIVE) or None
    yield "negative", -abs(value) - 1, (field in NOT_NEGATIVE) or None
    yield "zero", 0 * value, (field in POSITIVE) or None
    whole = field in ("elements", "degree", "points", "samples")
    yield "a fraction", value + 0.5, whole or None
    yield "many", 10**9, whole or None


def _text_changes(value, field):
    free = field in FREE_TEXT
    expression = field in ("mu", "p", "field")
    for new in (3, 1.5, [], {}, [value], True):
        yield "wrong type", new, (not expression) or None
    for new in ("", "inf", "nan", "no such", value + "x", value.upper() + "?", "\0", "a.b.c", "é"):
        yield f"{new!r}", new, (not free) or None
    for new in HOSTILE:
        yield f"hostile {new[:30]!r}", new, (not free) or None


def _list_changes(value, field):
    for new in ("text", {}, 3, True, float("nan")):
        yield "wrong type", new, True
    fixed = field in OF_SPACE
    yield "empty", [], fixed or None
    yield "reversed", value[::-1], None
    yield "longer", [*value, *value[:1]], fixed or None
    yield "shorter", value[:-1], fixed or None
    yield "nested", [value], True if value else None
    yield "deep", json.loads("[" * 50 + "]" * 50), True
    yield "very long", (value or [0.0]) * 5000, fixed or None


def _table_changes(value, field, path):
    for new in ("text", [], 3, True, [value]):
        yield "wrong type", new, (field != "friction_direction_on_a") or None
    free = path[-1] in NAMED
    yield "extra field", value | {"extra": 1}, True
    yield "odd names", value | {"": 1, "a.b": 2}, True
    if free:
        for name in ("a.b", "", "a,b", "new\nline", "x" * 1000, " "):
            other = next(iter(value.values()), {})
            yield f"a name {name[:8]!r}", value | {name: other}, True


def random_mutation(rng):
    """One mutation of one scene that comes with the project."""
    data = valid(str(rng.choice(NAMES)), str(rng.choice(["fe", "iga"])))
    path = _drawn(rng, list(places(data)))
    if isinstance(path[-1], str) and rng.random() < 0.1:
        must = path[-1] in REQUIRED or None
        return Bad("scene", f"{'.'.join(path_text(path))} missing", removed(data, path), must)
    words, new, refused = _drawn(rng, list(_changes(at(data, path), field_of(path), path)))
    if refused and not used(data, path) and words not in _ALWAYS:
        refused = None
    told = f"{data['name']}: {'.'.join(path_text(path))} {words}"
    return Bad("scene", told, replaced(data, path, new), refused, path)


def _drawn(rng, options):
    return options[int(rng.integers(len(options)))]


ALPHABET = "xyzr 0123456789.+-*/()[]{},:;'\"\\_=<>&|~^%!@#$\n\0éｘ∞"


def random_expression(rng):
    """A hostile text, whole or cut and joined; or characters that are no expression."""
    if rng.random() < 0.5:
        first, second = str(_drawn(rng, HOSTILE)), str(_drawn(rng, HOSTILE))
        text = first if rng.random() < 0.5 else first[: rng.integers(1, 40)] + second
    else:
        text = "".join(_drawn(rng, ALPHABET) for _ in range(rng.integers(1, 60)))
    return Bad("expression", f"expression {text[:60]!r}", text, True if text in HOSTILE else None)


def random_override(rng):
    """A setting of `--set` along a path that is there, broken or made up."""
    data = valid(str(rng.choice(NAMES)))
    parts = [str(key) for key in _drawn(rng, list(places(data)))]
    for _ in range(rng.integers(0, 3)):
        where = int(rng.integers(len(parts) + 1))
        parts.insert(where, _drawn(rng, ["", "0", "99", "-1", "x", "a b", "\0", "9" * 30, "é"]))
    value = _drawn(rng, SETTINGS)
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
        rows = _drawn(rng, [data["points"], data["cells"], data["surfaces"][name]])
        row = _drawn(rng, rows)
        wrong = [float("nan"), float("inf"), None, "1", [], {}, 1j, 10**400, True, -1e300]
        refused, wrong = (None, -1e300) if rng.random() < 0.05 else (True, _drawn(rng, wrong[:-2]))
        row[int(rng.integers(len(row)))] = wrong
    elif part == "facets":
        facets = data["surfaces"][name]
        data["surfaces"][name] = _drawn(rng, [[], facets * 2, [f[:-1] for f in facets], 3, None])
    elif part == "surfaces":
        data["surfaces"] = _drawn(rng, [None, 3, [], "x", {1: [[0, 1]]}, {name: {}}])
        refused = data["surfaces"] != []
        refused = True if refused else None
    elif part == "cell":
        data["cell"] = _drawn(rng, ["", "prism", None, 3, [], {}, "Hexahedron", b"hexahedron"])
    elif part == "order":
        data["order"] = _drawn(rng, [0, -1, 5, 1.0, "1", None, 10**20, True, [1]])
    elif part == "cells":
        cells = data["cells"]
        wrong = [[], cells * 2, [c[:-1] for c in cells], [[c[0]] * len(c) for c in cells], None, 3]
        data["cells"] = _drawn(rng, [*wrong, [cells], [[n + 1000 for n in c] for c in cells]])
    else:
        x = data["points"]
        data["points"] = _drawn(rng, [[], None, "x", [[*p, 0.0] for p in x], [x], x[0], x[:-1]])
    return Bad("mesh", f"mesh with wrong {part}: {str(data)[:150]}", data, refused)


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

    return {
        "scene": read_scene,
        "expression": lambda text: Expression(text)(np.full((3, 3), 0.4)),
        "override": override,
        "scene file": scene_file,
        "stored": stored,
        "mesh": lambda data: Mesh(**data),
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
        whole = _text_of(str(rng.choice(NAMES))).encode()
        content = random_file(rng, whole)
        return Bad("scene file", f"scene file {content[:40]!r}", content, None)
    if kind < 0.9:
        content = random_file(rng, stored)
        return Bad("stored", f"stored result {content[:40]!r}", content, None)
    return random_mesh(rng)
