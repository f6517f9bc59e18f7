"""What is raised when a scene is refused, and pydantic's errors as its lines.

pydantic tells of each error the path, its kind and the value. The path is made one that a person
writes, and names that were probably meant are added.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from cea.errors import InputError, did_you_mean

_SHOWN = 20
"""Faults that a message tells."""
_TAGS = ("shape", "method", "kind")
"""Fields that tell forms of a section apart."""
_MISSING = ("missing", "missing_argument")

_Sections = Sequence[Mapping[str, Any]]
"""Fields of every section, as a JSON Schema has them."""


class SceneError(ValueError):
    """A scene that is refused: one :class:`cea.errors.InputError` for each fault."""

    def __init__(self, faults: Iterable[InputError]) -> None:
        self.faults = tuple(faults)
        lines = [str(fault) for fault in self.faults[:_SHOWN]]
        if len(self.faults) > _SHOWN:
            lines.append(f"and {len(self.faults) - _SHOWN} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between ranks by its faults, not by its message."""
        return type(self), (self.faults,)


class Faults(list[InputError]):
    """Faults that are collected, to be told together."""

    def require(self, condition: bool, field: str, value: object, allowed: str) -> None:
        """Collect a fault unless a condition holds."""
        if not condition:
            self.append(InputError(field, value, allowed))

    def of(self, check: Callable[..., Any], *arguments: Any) -> None:
        """Collect the fault that a check raises."""
        try:
            check(*arguments)
        except InputError as error:
            self.append(error)

    def refuse(self) -> None:
        """Raise them, where there are any."""
        if self:
            raise SceneError(self)


def problems(error: ValidationError, data: Any, schema: Mapping[str, Any]) -> list[InputError]:
    """Faults that pydantic found in plain data, each under its own field.

    Names that were probably meant are those of a JSON Schema of what the data should be.
    """
    every = (schema, *schema.get("$defs", {}).values())
    sections = [section["properties"] for section in every if "properties" in section]
    found: dict[str, list[InputError]] = {}
    for detail in error.errors(include_url=False):
        fault = _fault(detail, data, sections)
        found.setdefault(fault.field, []).append(fault)
    # Of a field of several forms what is wrong within one says more than that it is no other.
    within = {field: any(other.startswith(f"{field}.") for other in found) for field in found}
    return [
        InputError(field, each[0].value, ", or ".join(dict.fromkeys(one.allowed for one in each)))
        for field, each in found.items()  # one for each form of the field
        if not within[field]
    ]


def _fault(detail: Mapping[str, Any], data: Any, sections: _Sections) -> InputError:
    """One error of pydantic, with names that were probably meant."""
    kind, value, (place, parent) = detail["type"], detail["input"], _place(detail, data)
    context, name = detail.get("ctx", {}), detail["loc"][-1] if detail["loc"] else ""
    names = [each for section in sections for each in section]
    given = value if isinstance(value, Mapping) else {}
    allowed = (detail["msg"][0].lower() + detail["msg"][1:]).removeprefix("input should be ")
    cause = context.get("error")
    if isinstance(cause, InputError):
        first, _, rest = cause.field.partition(".")  # which may be the section, or a field of it
        field = rest if rest and first not in given and place else cause.field
        return InputError(".".join(filter(None, (place, field))), cause.value, cause.allowed)
    match kind:
        case "unexpected_keyword_argument" | "extra_forbidden":
            siblings = _siblings(parent, name, sections)
            there = f"; there are {', '.join(siblings)}" if siblings else ""
            allowed = f"no such field{there}{did_you_mean(name, siblings or names)}"
        case "missing" if isinstance(name, int):
            place, allowed = place.rpartition(".")[0], f"at least {name + 1} entries"
        case "too_long":
            allowed = f"{context['max_length']} entries"
        case "missing" | "missing_argument":
            near = [each for each in given if each not in names and did_you_mean(each, [name])]
            value, allowed = None, allowed + (f"; is it meant by {near[0]!r}?" if near else "")
        case "union_tag_invalid" | "union_tag_not_found":
            tag = context["discriminator"].strip("'()")
            value, place = given.get(tag), f"{place}.{tag}"
            kinds = [each[tag]["const"] for each in sections if "const" in each.get(tag, {})]
            tags = context.get("expected_tags", "").split("'")[1::2] or kinds
            needed = "" if value else "needed: "
            allowed = f"{needed}one of {', '.join(tags)}{did_you_mean(value, tags)}"
        case "form":  # of a union whose forms are told apart by the fields that are given
            unknown = [each for each in given if each not in names]
            allowed += "".join(did_you_mean(each, names) for each in unknown)
        case "literal_error":
            allowed += did_you_mean(value, context["expected"].split("'")[1::2])
    return InputError(place or "scene", value, allowed)


def _siblings(section: Any, wrong: Any, sections: _Sections) -> list[str]:
    """Fields of the section that this probably is: it has the others, and one of a like name."""
    others = set(section) - {wrong} if isinstance(section, Mapping) else set()
    fitting = [list(names) for names in sections if others <= set(names)] if others else []
    return min(fitting, key=lambda names: (not did_you_mean(wrong, names), len(names)), default=[])


def _place(detail: Mapping[str, Any], data: Any) -> tuple[str, Any]:
    """Path of a field as a person writes it, without the names of forms; and what it lies in."""
    place: list[str] = []
    parent, named = data, False
    for part in detail["loc"]:
        in_table = isinstance(data, Mapping) and part in data
        if in_table and not named and part in [data.get(tag) for tag in _TAGS]:
            named = True  # pydantic names the form of a section before its fields
        elif in_table or (isinstance(data, list) and isinstance(part, int) and part < len(data)):
            place.append(str(part))
            parent, data, named = data, data[part], False
    if detail["type"] in _MISSING:
        place.append(str(detail["loc"][-1]))
    return ".".join(place), parent
