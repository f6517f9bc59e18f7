"""The table of wrong inputs in ``tests/data/bad_inputs.toml``, and how each is met."""

import tomllib
from copy import deepcopy
from pathlib import Path
from time import perf_counter

from scene_mutations import at

from cea.errors import InputError
from scenes.checking.check import inspect_scene
from scenes.spec.plain import set_fields, tables_of
from scenes.spec.problems import SceneError
from scenes.spec.reading import read_scene

TABLE = tomllib.loads((Path(__file__).parents[1] / "data" / "bad_inputs.toml").read_text())
PATIENCE = 10.0
"""Seconds that an input may take; they take milliseconds on an idle machine."""
COARSE = {
    "disc_pad": {"pad": [3, 5, 2], "disc": [5, 24, 1]},
    "blocks": {"upper": [8, 2], "lower": [7, 3]},
}
"""Elements with which scenes are built, both backends alike."""


def rows(part):
    """Every row of a part of the table: base, changes, field, word."""
    return [
        (base, [changes] if isinstance(changes, str) else changes, field, word)
        for base, groups in TABLE[part].items()
        for group in groups.values()
        for changes, field, word in group
    ]


def coarse(base):
    """A scene of the catalogue as plain data, with few elements."""
    data = tables_of(base)
    for name, elements in COARSE[base].items():
        for mesh in data["bodies"][name]["mesh"].values():
            mesh["elements"] = elements
            mesh.pop("through", None)
    return data


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


def faults_of_row(part, base, changes):
    """Faults of an input and the seconds it took."""
    start, found = perf_counter(), []
    try:
        scene = read_scene(changed(tables_of(base) if part == "read" else coarse(base), changes))
        if part == "built":
            found = list(inspect_scene(scene).faults)
    except SceneError as error:
        found = list(error.faults)
    except InputError as error:
        found = [error]
    return found, perf_counter() - start


def complaint(found, seconds, field, word):
    """What is wrong with how an input was met; None where all is well."""
    if not found:
        return "accepted"
    if seconds > PATIENCE:
        return f"took {seconds:.0f} s"
    named = [str(fault) for fault in found if fault.field == field]
    if not named:
        return f"another field: {'; '.join(map(str, found))}"
    if not any(word in line for line in named):
        return f"{word!r} not in: {'; '.join(named)}"
    if any("\n" in str(fault) for fault in found):
        return "a message of several lines"
    return None
