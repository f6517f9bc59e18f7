"""Bad input for everything that reads, and how each is met.

Scenes have one thing wrong: a row of ``tests/data/bad_inputs.toml``, or any value in any place. A
refusal is told in short lines that name a field; anything else is a crash.
"""

import signal
import tomllib
from contextlib import contextmanager
from copy import deepcopy
from pathlib import Path

from cea.errors import InputError
from scenes.checking.check import inspect_scene
from scenes.spec.plain import SCENES, set_fields, tables_of
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

TABLE = tomllib.loads((Path(__file__).parents[1] / "data" / "bad_inputs.toml").read_text())
PATIENCE = 20.0
"""Seconds after which an input hangs; each takes milliseconds, or is built on few elements."""
NAMES = sorted(file.stem for file in SCENES.glob("*.toml"))
BY_SIZE = {"ventilated_brake"}
"""Scenes whose meshes have sizes, not numbers of elements: none is coarse."""
HOSTILE = [
    "__import__('os').system('touch stolen')",
    "().__class__.__bases__[0].__subclasses__()",
    "[y for y in x]",
    "10**10**10",
    "1 << 100000",
    "(" * 500 + "x" + ")" * 500,
    "x+" * 900 + "x",
    "x" * 100_000,
    "sin(x, out=y)",
    "f'{x.__class__}'",
    "x := 3",
    "import os",
    "x[0]",
    "\0",
    "",
    "nan",
    "1e999",
    "\ud800",
]
"""Texts that are no expression: they run code, climb out, or ask for more than there is."""


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


def assert_told_well(error):
    """A refusal names fields and what is allowed, in few lines that are not long."""
    lines = str(error).splitlines()
    assert len(lines) <= 21
    assert max(map(len, lines)) <= 2500
    assert all(fault.field and fault.allowed for fault in faults_of(error))


def complaints(part, base):
    """What is met badly of a part of the table: rows of changes, field, word."""
    rows = [row for group in TABLE[part][base].values() for row in group]
    return [told for row in rows if (told := complaint_of_row(part, base, *row))]


def changed(data, changes):
    """Plain data with changes, one or several: settings, and fields taken away."""
    data = deepcopy(data)
    for change in [changes] if isinstance(changes, str) else changes:
        if change.startswith("! "):
            *path, last = change[2:].split(".")
            del at(data, path)[last]
        else:
            set_fields(data, [change])
    return data


def complaint_of_row(part, base, changes, field, word):
    """What is wrong with the refusal of a row, whose scene is read, or built too."""
    found = []
    try:
        data = tables_of(base) if part == "read" else coarse(base, elements=BUILT)
        with patience():
            scene = read_scene(changed(data, changes))
            if part == "built":
                found = inspect_scene(scene).faults
    except (SceneError, InputError) as error:
        found = faults_of(error)
    named = [str(fault) for fault in found if fault.field == field]
    if not any(word in line for line in named):
        return f"{changes}: {field} with {word!r} is not in: {'; '.join(map(str, found))}"
    several = any("\n" in str(fault) for fault in found)
    return f"{changes}: of several lines" if several else None


def valid(name, backend="iga"):
    """A scene that comes with the project, as plain data, all bodies on one backend."""
    data = tables_of(name)
    for body in data["bodies"].values():
        body["backend"] = backend
    return data


COARSE = {
    "upper": [3, 2, 2],
    "lower": [4, 2, 2],
    "disc": [2, 12, 1],
    "pad": [2, 3, 1],
    "outer": [1, 8, 1],
    "inner": [1, 12, 1],
}
"""Elements of the bodies of the scenes, so few that a run takes a moment."""


BUILT = {"pad": [3, 5, 2], "disc": [5, 24, 1], "upper": [8, 2], "lower": [7, 3]}
"""The same where scenes are built."""


def coarse(name, backend="iga", elements=COARSE):
    """The same on few elements."""
    data = valid(name, backend)
    for body_name, body in data["bodies"].items():
        for mesh in body["mesh"].values():
            mesh["elements"] = elements[body_name][: len(mesh["elements"])]
            mesh.pop("through", None)
    return data


def places(value, path=()):
    """Every place of nested data but the root."""
    for key, part in value.items() if isinstance(value, dict) else enumerate(value):
        yield (*path, key)
        if isinstance(part, dict | list):
            yield from places(part, (*path, key))


def at(data, path):
    for key in path:
        data = data[key]
    return data


def with_value(data, path, value):
    """The data with another value at a place."""
    data = deepcopy(data)
    at(data, path[:-1])[path[-1]] = value
    return data
