"""Scenes as plain data in which fields that say nothing are left out.

Stored numbers are found by fingerprints of their scenes: a field that came later than they did must
not stand there where it has its default.
"""

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any


def as_data(section: Any) -> Any:
    """A scene or a section of one as nested dictionaries, as :func:`dataclasses.asdict` gives it.

    Parameters
    ----------
    section
        Dataclasses, and tables and lists of them. Fields that a class names in ``left_out`` are
        left out where they have their defaults.
    """
    if is_dataclass(section):
        return {
            field.name: as_data(value)
            for field in fields(section)
            if not _is_left_out(section, field, value := getattr(section, field.name))
        }
    if isinstance(section, Mapping):
        return {name: as_data(part) for name, part in section.items()}
    if isinstance(section, list | tuple):
        return type(section)(as_data(part) for part in section)
    return section


def _is_left_out(section: Any, field: Field[Any], value: Any) -> bool:
    """Whether a field may be left out, and has the value that it then has."""
    if field.name not in getattr(section, "left_out", ()):
        return False
    default = field.default if field.default is not MISSING else None
    return bool(value == default)
