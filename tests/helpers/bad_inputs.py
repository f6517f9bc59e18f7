"""Bad input for everything that reads, and how each is met.

Scenes have one thing wrong: a row of ``tests/data/bad_inputs.toml``, or a field of a valid scene
broken in every way. A refusal is told in short lines that name a field; anything else is a crash.
"""

import signal
import tomllib
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from cea.errors import ConvergenceError, InputError
from scenes.checking.check import inspect_scene
from scenes.spec.plain import SCENES, set_fields, tables_of
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

TABLE = tomllib.loads((Path(__file__).parents[1] / "data" / "bad_inputs.toml").read_text())
PATIENCE = 20.0
"""Seconds after which an input hangs; each takes milliseconds on a machine with nothing else."""
PATIENCE_OF_ROWS = 10.0
"""The same of a row of the table, which is read once, or built on few elements."""
REFUSALS = (InputError, SceneError, ConvergenceError)
NAMES = sorted(file.stem for file in SCENES.glob("*.toml"))
BY_SIZE = {"ventilated_brake"}
"""Scenes whose meshes have sizes, not numbers of elements: none is coarse."""
POSITIVE = [
    "E", "rho", "P", "p", "c_n", "m_n", "max_frequency", "inner_radius", "outer_radius", "size",
    "frequencies", "degree", "elements", "points", "samples",
]  # fmt: skip
"""Fields whose numbers are greater than zero."""
NOT_NEGATIVE = ["mu", "growth_threshold", "pictures", "paraview", "alpha", "beta", "rate", "ratios"]
WHOLE = ("elements", "degree", "points", "samples")
REQUIRED = [
    "name", "bodies", "analysis", "kind", "max_frequency", "backend", "geometry", "material",
    "mesh", "E", "nu", "shape", "a", "b", "formulation", "method", "surface", "pressure",
    "inner_radius", "outer_radius", "bottom", "top", "start", "end", "vector",
    "circumferential_about",
]  # fmt: skip
MAY_BE_NONE = [
    "P", "p", "m_n", "growth_threshold", "min_growth", "rho", "alpha", "beta", "mu_slope",
    "reach",
]  # fmt: skip
"""Numbers that may be left out, beside others."""
FREE_TEXT = ("name", "description")
EXPRESSIONS = ("mu", "p", "added_gap", "field", "speed", "pressure", "mu_slope")
NAMED = ("bodies", "contacts", "through", "faces")
"""Tables whose names are free."""
OF_SPACE = ("vector", "elements", "degree", "origin", "axis", "circumferential_about")
"""Lists as long as space has dimensions, or as three."""
ALWAYS = ("not a number", "huge", "wrong type", "extra field", "infinite")
"""Changes that are refused in meshes of the other backend too, which are only looked through."""
HOSTILE = [
    "__import__('os').system('touch stolen')",
    "().__class__.__bases__[0].__subclasses__()",
    "x.__class__.__mro__[1].__subclasses__()",
    "x.tofile('stolen')",
    "sin.__globals__",
    "open('/etc/passwd').read()",
    "(lambda: 1)()",
    "[y for y in x]",
    "{z: 1 for z in x}",
    "exec('1')",
    "10**10**10",
    "9**9**9**9",
    "'a'*10**10",
    "[0]*10**10",
    "1 << 100000",
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
    "1j",
    "True",
    "None",
    "...",
    "x[0]",
    "x @ y",
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


@dataclass(frozen=True)
class Bad:
    """An input: what reads it, what it is in words, and whether it must be refused.

    ``refused`` is True where the value is bad whatever the rest says, None where it may be right.
    """

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
    """What is wrong with how an input was met, in words; None where all is well."""
    try:
        with patience():
            read(bad.value)
    except REFUSALS as error:
        lines = str(error).splitlines()
        if isinstance(error, InputError | SceneError):
            faults = faults_of(error)
            if not faults or not all(fault.field and fault.allowed for fault in faults):
                return f"{bad.words}: refused without a name: {error}"
            near = any(fault.field.startswith(str(bad.place[0])) for fault in faults if bad.place)
            if bad.refused and bad.place and not near:
                return f"{bad.words}: refused under another name: {lines[0]}"
        if len(lines) > 21 or max(map(len, lines)) > 2500:
            return f"{bad.words}: a refusal of {len(str(error))} characters"
        return None
    except Exception as error:
        return f"{bad.words}: {type(error).__name__}: {str(error)[:200]}"
    return f"{bad.words}: accepted" if bad.refused else None


def rows(part):
    """Every row of a part of the table: base, changes, field, word."""
    return [
        (base, [changes] if isinstance(changes, str) else changes, field, word)
        for base, groups in TABLE[part].items()
        for group in groups.values()
        for changes, field, word in group
    ]


def changed(data, changes):
    """Plain data with changes: settings, and fields taken away."""
    data = deepcopy(data)
    for change in changes:
        if change.startswith("! "):
            *path, last = change[2:].split(".")
            del at(data, path)[last]
        else:
            set_fields(data, [change])
    return data


def complaint_of_row(part, base, changes, field, word):
    """The same of a row of the table, whose scene is read, or built too."""
    start, found = perf_counter(), []
    try:
        data = tables_of(base) if part == "read" else coarse(base, elements=BUILT)
        scene = read_scene(changed(data, changes))
        if part == "built":
            found = inspect_scene(scene).faults
    except (SceneError, InputError) as error:
        found = faults_of(error)
    named = [str(fault) for fault in found if fault.field == field]
    if not any(word in line for line in named):
        return f"{changes}: {field} with {word!r} is not in: {'; '.join(map(str, found))}"
    slow = perf_counter() - start > PATIENCE_OF_ROWS
    several = any("\n" in str(fault) for fault in found)
    return f"{changes}: slow, or of several lines" if slow or several else None


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


def mutations(data):
    """Every mutation of a valid scene, field by field."""
    for path in places(data):
        yield from mutations_at(data, path)


def mutations_at(data, path):
    """Every mutation of one place."""
    value, told = at(data, path), f"{data['name']}: {'.'.join(map(str, path))}"
    field = next((key for key in reversed(path) if isinstance(key, str)), "")
    of_mesh = len(path) > 3 and path[2] == "mesh"
    looked_through = of_mesh and path[3] != data["bodies"][path[1]]["backend"]
    for words, new, refused in _changes(value, field, path):
        copy = deepcopy(data)
        at(copy, path[:-1])[path[-1]] = new
        unread = looked_through and words not in ALWAYS
        yield Bad(f"{told} {words}", copy, None if unread else refused, path)
    if isinstance(path[-1], str):
        copy = deepcopy(data)
        del at(copy, path[:-1])[path[-1]]
        yield Bad(f"{told} missing", copy, path[-1] in REQUIRED or None)


def _changes(value, field, path):
    """New values of a place, each with its name and whether it must be refused."""
    if isinstance(value, bool):
        yield from ((f"{new!r} for a truth value", new, True) for new in ("yes", 1, [], {}))
    elif isinstance(value, int | float):
        yield from _number_changes(value, field)
    elif isinstance(value, str):
        yield from _text_changes(value, field)
    elif isinstance(value, list):
        yield from _list_changes(value, field)
    else:
        yield from _table_changes(value, field, path)


def _number_changes(value, field):
    for new in ("text", [], {}, [value], {"value": value}, True):
        yield "wrong type", new, True
    yield "none", None, field not in MAY_BE_NONE or None
    yield "not a number", float("nan"), True
    tied = field in ("P", "p")  # where the form is open or saddle, such a stiffness ties the sides
    for new in (float("inf"), -float("inf")):
        yield "infinite", new, (not (tied and new > 0)) or None
    for new in (1e300, -1e300, 10**400):
        yield "huge", new, (not (tied and new > 0)) or None
    yield "next to nothing", 1e-300, (field in POSITIVE) or None
    yield "negative", -abs(value) - 1, (field in [*POSITIVE, *NOT_NEGATIVE]) or None
    yield "zero", 0 * value, (field in POSITIVE) or None
    yield "a fraction", value + 0.5, (field in WHOLE) or None
    yield "many", 10**9, (field in WHOLE) or None


def _text_changes(value, field):
    for new in (3, 1.5, [], {}, [value], True):
        yield "wrong type", new, (field not in EXPRESSIONS) or None
    others = ("", "inf", "nan", "no such", value + "x", value.upper() + "?", "\0", "a.b.c", "é")
    for new in (*others, *HOSTILE):
        yield repr(new[:30]), new, (field not in FREE_TEXT) or None


def _list_changes(value, field):
    for new in ("text", {}, 3, True, float("nan")):
        yield "wrong type", new, True
    fixed = field in OF_SPACE or None
    yield "empty", [], fixed
    yield "reversed", value[::-1], None
    yield "longer", [*value, *value[:1]], fixed
    yield "shorter", value[:-1], fixed
    yield "nested", [value], True if value else None
    deep = []
    for _ in range(49):
        deep = [deep]
    yield "deep", deep, True
    yield "very long", (value or [0.0]) * 5000, fixed


def _table_changes(value, field, path):
    for new in ("text", [], 3, True, [value]):
        yield "wrong type", new, (field != "friction_direction_on_a") or None
    yield "extra field", value | {"extra": 1}, True
    yield "odd names", value | {"": 1, "a.b": 2}, True
    for name in ("a.b", "", "a,b", "new\nline", "x" * 1000, " ") if path[-1] in NAMED else ():
        yield f"a name {name[:8]!r}", value | {name: next(iter(value.values()), {})}, True


def random_mutation(rng, made=valid):
    """One mutation of one scene that comes with the project, as it is or :func:`coarse`."""
    names = [name for name in NAMES if made is valid or name not in BY_SIZE]
    data = made(drawn(rng, names), drawn(rng, ["fe", "iga"]))
    return drawn(rng, list(mutations_at(data, drawn(rng, list(places(data))))))


def drawn(rng, options):
    return options[int(rng.integers(len(options)))]
