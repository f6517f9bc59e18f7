"""Scenes with one thing wrong: every field of a valid one broken in every way.

A mutation knows whether it must be refused: True where the value is bad whatever the rest says,
None where it may be right.
"""

import json
import tomllib
from copy import deepcopy
from dataclasses import dataclass
from functools import cache
from typing import Any

from scenes.spec.plain import SCENES

NAMES = sorted(file.stem for file in SCENES.glob("*.toml"))
POSITIVE = {
    *("E", "rho", "P", "p", "max_frequency", "inner_radius", "outer_radius", "degree", "elements"),
    *("size", "points", "samples", "frequencies", "c_n", "m_n"),
}
"""Fields whose numbers are greater than zero."""
NOT_NEGATIVE = POSITIVE | {
    *("mu", "growth_threshold", "pictures", "paraview", "alpha", "beta", "rate", "ratios"),
}
REQUIRED = {
    *("backend", "geometry", "material", "mesh", "E", "nu", "shape", "a", "b", "formulation"),
    *("name", "bodies", "analysis", "kind", "max_frequency", "method", "surface", "pressure"),
    *("inner_radius", "outer_radius", "bottom", "top", "start", "end", "vector"),
    "circumferential_about",
}
MAY_BE_NONE = {
    *("P", "p", "m_n", "growth_threshold", "min_growth", "rho", "alpha", "beta", "mu_slope"),
    "reach",
}
"""Numbers that may be left out, beside others."""
FREE_TEXT = {"name", "description"}
NAMED = {"bodies", "contacts", "through", "faces"}
"""Tables whose names are free."""
OF_SPACE = {"vector", "elements", "degree", "origin", "axis", "circumferential_about"}
"""Lists as long as space has dimensions, or as three."""
HOSTILE = [
    *("__import__('os').system('touch stolen')", "().__class__.__bases__[0].__subclasses__()"),
    *("x.__class__.__mro__[1].__subclasses__()", "x.tofile('stolen')", "sin.__globals__"),
    *("open('/etc/passwd').read()", "(lambda: 1)()", "[y for y in x]", "{z: 1 for z in x}"),
    *("exec('1')", "10**10**10", "9**9**9**9", "'a'*10**10", "[0]*10**10", "1 << 100000"),
    *("(" * 500 + "x" + ")" * 500, "-" * 1500 + "x", "x+" * 900 + "x", "x" * 100_000),
    *("sin(x, y)", "where(x > 0)", "sin(x, out=y)", "maximum(x, y, z)", "f'{x.__class__}'"),
    *("x if x else y", "x := 3", "x = 3", "import os", "x; y", "1j", "True", "None", "..."),
    *("x[0]", "x @ y", "\0", "", "nan", "inf", "1e999", "\ud800", "ｘ.real", "x.real"),
]
"""Texts that are no expression: they run code, climb out, or ask for more than there is."""


@dataclass(frozen=True)
class Bad:
    """An input: what reads it, what it is in words, and whether it must be refused."""

    kind: str
    words: str
    value: Any
    refused: bool | None
    place: tuple[Any, ...] = ()


@cache
def text_of(name):
    return (SCENES / f"{name}.toml").read_text()


def valid(name, backend="iga"):
    """A scene that comes with the project, as plain data, all bodies on one backend."""
    data = tomllib.loads(text_of(name))
    for body in data["bodies"].values():
        body["backend"] = backend
    return data


COARSE = {
    **{"upper": [3, 2, 2], "lower": [4, 2, 2], "disc": [2, 12, 1], "pad": [2, 3, 1]},
    **{"outer": [1, 8, 1], "inner": [1, 12, 1]},
}
"""Elements of the bodies of the scenes, so few that a run takes a moment."""


_BY_SIZE = {"ventilated_brake"}
"""Scenes whose meshes have sizes, not numbers of elements: none is coarse."""


def coarse(name, backend):
    """The same on few elements."""
    data = valid(name, backend)
    for body_name, body in data["bodies"].items():
        for mesh in body["mesh"].values():
            mesh["elements"] = COARSE[body_name][: len(mesh["elements"])]
            mesh.pop("through", None)
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
    yield "none", None, field not in MAY_BE_NONE or None
    yield "not a number", float("nan"), True
    tied = field in ("P", "p")  # where the form is open or saddle, such a stiffness ties the sides
    for new in (float("inf"), -float("inf")):
        yield "infinite", new, (not (tied and new > 0)) or None
    for new in (1e300, -1e300, 10**400):
        yield "huge", new, (not (tied and new > 0)) or None
    yield "next to nothing", 1e-300, (field in POSITIVE) or None
    yield "negative", -abs(value) - 1, (field in NOT_NEGATIVE) or None
    yield "zero", 0 * value, (field in POSITIVE) or None
    whole = field in ("elements", "degree", "points", "samples")
    yield "a fraction", value + 0.5, whole or None
    yield "many", 10**9, whole or None


def _text_changes(value, field):
    free = field in FREE_TEXT
    expression = field in ("mu", "p", "added_gap", "field", "speed", "pressure", "mu_slope")
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


def random_mutation(rng, made=valid):
    """One mutation of one scene that comes with the project, as it is or :func:`coarse`."""
    names = [name for name in NAMES if made is valid or name not in _BY_SIZE]
    data = made(str(rng.choice(names)), str(rng.choice(["fe", "iga"])))
    path = drawn(rng, list(places(data)))
    if isinstance(path[-1], str) and rng.random() < 0.1:
        must = path[-1] in REQUIRED or None
        return Bad("scene", f"{'.'.join(path_text(path))} missing", removed(data, path), must)
    words, new, refused = drawn(rng, list(_changes(at(data, path), field_of(path), path)))
    if refused and not used(data, path) and words not in _ALWAYS:
        refused = None
    told = f"{data['name']}: {'.'.join(path_text(path))} {words}"
    return Bad("scene", told, replaced(data, path, new), refused, path)


def drawn(rng, options):
    return options[int(rng.integers(len(options)))]
