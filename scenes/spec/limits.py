"""What a scene is refused for whatever its fields mean: names that no path holds, extreme numbers.

Products of a few numbers must stay in the range of floating point numbers.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict
from typing import Any

from cea.errors import InputError
from scenes.spec.scene import SceneSpec

LARGEST, SMALLEST = 1e30, 1e-30
"""Range of numbers, in the unit of each: lengths, stiffness and densities of any units fit."""

MAX_ITEMS = 200
"""Bodies, contacts and loads of a scene, supports and springs of a body, of each so many."""

_LONGEST = 100
"""Characters of a name."""

_PARTING = ".,[] "
"""Characters that part the names of a path, which no name may hold."""

_SCALES = (
    "E", "rho", "P", "p", "c_n", "max_frequency", "size", "inner_radius", "outer_radius", "bore",
    "hub_radius", "reach", "speed", "frequencies",
)  # fmt: skip
"""Fields that set scales, and may not be next to nothing; coordinates and the like may."""


_LARGEST_OF = {"c_n": 1e90, "m_n": 20.0}
"""Fields of another range: c_n is a pressure over a small length to the power of m_n."""


def limit_checks(scene: SceneSpec) -> Iterable[InputError]:
    """Faults of names and numbers."""
    yield from scene_name_checks(scene.name)
    yield from _count_checks(scene)
    for kind, names in (("bodies", scene.bodies), ("contacts", scene.contacts)):
        for name in names:
            yield from _name_checks(kind, name)
    for body, spec in scene.bodies.items():
        for name in spec.geometry.surfaces:
            yield from _name_checks(f"bodies.{body}.geometry.faces", name)
    for place, number in _numbers(asdict(scene), ""):
        yield from _number_checks(place, number)


def _count_checks(scene: SceneSpec) -> Iterable[InputError]:
    counts = {
        "bodies": len(scene.bodies),
        "contacts": len(scene.contacts),
        "loads": len(scene.loads),
    }
    for name, body in scene.bodies.items():
        counts[f"bodies.{name}.supports"] = len(body.supports)
        counts[f"bodies.{name}.springs"] = len(body.springs)
    for place, count in counts.items():
        if count > MAX_ITEMS:
            yield InputError(place, f"{count} of them", f"at most {MAX_ITEMS}")


def scene_name_checks(name: str) -> Iterable[InputError]:
    """Faults of the name of a scene, which files and lines on a terminal bear."""
    if not (0 < len(name.strip()) <= len(name) <= _LONGEST and name.isprintable()):
        yield InputError("name", name, f"a name of 1 to {_LONGEST} printable characters")


def _name_checks(place: str, name: str) -> Iterable[InputError]:
    fits = 0 < len(name) <= _LONGEST and name.isprintable()
    if not fits or set(name) & set(_PARTING):
        allowed = f"1 to {_LONGEST} printable characters, no dot, comma, bracket or blank"
        yield InputError(place, name, allowed)


def _numbers(value: Any, place: str) -> Iterator[tuple[str, float]]:
    """Numbers of nested tables and lists by their paths."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _numbers(part, f"{place}.{name}" if place else name)
    elif isinstance(value, list | tuple):
        for i, part in enumerate(value):
            yield from _numbers(part, f"{place}.{i}")
    elif isinstance(value, int | float):
        yield place, value


def _number_checks(place: str, number: float) -> Iterable[InputError]:
    field = next(part for part in reversed(place.split(".")) if not part.isdecimal())
    largest = _LARGEST_OF.get(field, LARGEST)
    if abs(number) > largest and not (field in ("P", "p") and number == float("inf")):
        yield InputError(place, number, f"at most {largest:g}")
    elif field in _SCALES and 0 < abs(number) < SMALLEST:
        yield InputError(place, number, f"at least {SMALLEST:g}")
