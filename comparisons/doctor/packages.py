"""Python and the packages that the project asks for: installed, and new enough."""

import re
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version

from comparisons.doctor.finding import Finding

_PROJECT = "friction-cea"
_OLDEST = (3, 12)
"""Python."""
_REQUIREMENT = re.compile(
    r"(?P<name>[\w.-]+)(\[[^\]]*\])?\s*(?P<bounds>[^;]*)(;.*extra == ['\"](?P<extra>\w+)['\"])?"
)
_BOUND = re.compile(r"(>=|<)\s*([\d.]+)")


def python() -> Finding:
    """The running Python."""
    told = ".".join(map(str, sys.version_info[:3]))
    if sys.version_info[:2] >= _OLDEST:
        return Finding("python", told)
    needed = ".".join(map(str, _OLDEST))
    return Finding("python", told, f"install Python {needed} or newer, then: make setup")


def packages() -> Iterator[Finding]:
    """Every package that the project needs, and those of its extras that are installed."""
    try:
        required = requires(_PROJECT) or []
    except PackageNotFoundError:
        mend = "in the folder of the project: make setup"
        yield Finding(_PROJECT, "not installed: runs from its folder, or not at all", mend)
        return
    yield Finding(_PROJECT, version(_PROJECT))
    for requirement in required:
        match = _REQUIREMENT.match(requirement)
        if match is not None and match["extra"] != "dev":
            yield package(match["name"], match["bounds"].strip(), match["extra"])


def package(name: str, bounds: str, extra: str | None = None) -> Finding:
    """One package.

    Parameters
    ----------
    name
        Its name.
    bounds
        Versions that will do, as ``>=0.11,<0.12``.
    extra
        Extra of the project that asks for it; without it the rest runs.
    """
    label = name if extra is None else f"{name} (extra {extra})"
    whole = _PROJECT if extra is None else f"{_PROJECT}[{extra}]"
    mend = f"python -m pip install '{whole}'"
    try:
        found = version(name)
    except PackageNotFoundError:
        if extra is not None:
            return Finding(label, f"not installed, may be: {mend}")
        return Finding(label, "not installed", mend)
    if not suits(found, bounds):
        return Finding(label, f"{found}, not {bounds}", f"python -m pip install '{name}{bounds}'")
    return Finding(label, found)


def suits(found: str, bounds: str) -> bool:
    """Whether a version lies within bounds."""
    have = _numbers(found)
    for sign, limit in _BOUND.findall(bounds):
        at_least = have >= _numbers(limit)
        if at_least != (sign == ">="):
            return False
    return True


def _numbers(text: str) -> tuple[int, ...]:
    """The numbers a version begins with; zeros at its end say nothing."""
    numbers = [int(number) for number in re.findall(r"\d+", re.split(r"[^\d.]", text)[0])]
    while numbers and not numbers[-1]:
        numbers.pop()
    return tuple(numbers)
