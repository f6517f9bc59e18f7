"""Error raised for an invalid scene, and conversion of pydantic's errors to input errors.

The path of each pydantic error is converted to the path in the scene file, and similar names are
suggested.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NoReturn

from pydantic import ValidationError

from cea.errors import InputError, did_you_mean

_SHOWN = 20
"""Largest number of faults listed in a message."""
_TAGS = ("shape", "method", "kind")
"""Discriminator fields of unions of sections."""
_MISSING = ("missing", "missing_argument")

_Sections = Sequence[Mapping[str, Any]]
"""Fields of every section: the ``properties`` of a JSON Schema."""


class SceneError(ValueError):
    """Error for an invalid scene, with one :class:`cea.errors.InputError` for each fault."""

    def __init__(self, faults: Iterable[InputError]) -> None:
        self.faults = tuple(faults)
        lines = [str(fault) for fault in self.faults[:_SHOWN]]
        if len(self.faults) > _SHOWN:
            lines.append(f"and {len(self.faults) - _SHOWN} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the faults, not the message, when the error is sent between ranks."""
        return type(self), (self.faults,)


def refuse(field: str, value: object, allowed: str) -> NoReturn:
    """Raise a SceneError with one fault."""
    raise SceneError([InputError(field, value, allowed)])


class Faults(list[InputError]):
    """List of input errors, collected to be raised together."""

    def require(self, condition: bool, field: str, value: object, allowed: str) -> None:
        """Append an error unless the condition holds."""
        if not condition:
            self.append(InputError(field, value, allowed))

    def of(self, check: Callable[..., Any], *arguments: Any) -> None:
        """Call a check and append the InputError that it raises."""
        try:
            check(*arguments)
        except InputError as error:
            self.append(error)

    def refuse(self) -> None:
        """Raise a SceneError if there are any faults."""
        if self:
            raise SceneError(self)


def problems(error: ValidationError, data: Any, schema: Mapping[str, Any]) -> list[InputError]:
    """Convert a pydantic error to input errors, one for each field.

    Suggestions for misspelt names are taken from the JSON Schema of the data.
    """
    every = (schema, *schema.get("$defs", {}).values())
    sections = [section["properties"] for section in every if "properties" in section]
    found: dict[str, list[InputError]] = {}
    for detail in error.errors(include_url=False):
        fault = _fault(detail, data, sections)
        found.setdefault(fault.field, []).append(fault)
    # For a union, errors inside one form are more specific than a mismatch with the others.
    within = {field: any(other.startswith(f"{field}.") for other in found) for field in found}
    return [
        InputError(field, each[0].value, ", or ".join(dict.fromkeys(one.allowed for one in each)))
        for field, each in found.items()  # one for each form of the field
        if not within[field]
    ]


def _fault(detail: Mapping[str, Any], data: Any, sections: _Sections) -> InputError:
    """Convert one pydantic error to an input error, with suggestions for misspelt names."""
    kind, value, (place, parent) = detail["type"], detail["input"], _place(detail, data)
    context, name = detail.get("ctx", {}), detail["loc"][-1] if detail["loc"] else ""
    names = [each for section in sections for each in section]
    given = value if isinstance(value, Mapping) else {}
    allowed = (detail["msg"][0].lower() + detail["msg"][1:]).removeprefix("input should be ")
    cause = context.get("error")
    if isinstance(cause, InputError):
        first, _, rest = cause.field.partition(".")  # the section or one of its fields
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
            value, allowed = None, allowed + (f"; is {near[0]!r} a misspelling?" if near else "")
        case "union_tag_invalid" | "union_tag_not_found":
            tag = context["discriminator"].strip("'()")
            value, place = given.get(tag), f"{place}.{tag}"
            kinds = [each[tag]["const"] for each in sections if "const" in each.get(tag, {})]
            tags = context.get("expected_tags", "").split("'")[1::2] or kinds
            needed = "" if value else "needed: "
            allowed = f"{needed}one of {', '.join(tags)}{did_you_mean(value, tags)}"
        case "form":  # a union discriminated by the fields that are given
            unknown = [each for each in given if each not in names]
            allowed += "".join(did_you_mean(each, names) for each in unknown)
        case "literal_error":
            allowed += did_you_mean(value, context["expected"].split("'")[1::2])
    return InputError(place or "scene", value, allowed)


def _siblings(section: Any, wrong: Any, sections: _Sections) -> list[str]:
    """Return the fields of the smallest section with all other fields, best with a similar name."""
    others = set(section) - {wrong} if isinstance(section, Mapping) else set()
    fitting = [list(names) for names in sections if others <= set(names)] if others else []
    return min(fitting, key=lambda names: (not did_you_mean(wrong, names), len(names)), default=[])


def _place(detail: Mapping[str, Any], data: Any) -> tuple[str, Any]:
    """Return the path of a field as in a scene file, without union tags, and its parent data."""
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
