"""What is raised when a scene is refused, and pydantic's errors as its lines.

pydantic tells of each error the path, its kind and the value. The path is made one that a person
writes, and names that were probably meant are added.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from cea.errors import InputError, did_you_mean

_SHOWN = 20
"""Faults that a message tells."""
_KINDS = {
    **{"float": "a number", "int": "a whole number", "string": "text", "bool": "true or false"},
    **{"tuple": "a list", "list": "a list", "dict": "a table", "dataclass": "a table"},
}
"""Kinds of values by the first word of pydantic's types of errors."""
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


def fault_of(check: Callable[..., Any], *arguments: Any) -> Iterator[InputError]:
    """Fault that a shared check finds, collected with the others rather than raised."""
    try:
        check(*arguments)
    except InputError as error:
        yield error


def problems(error: ValidationError, data: Any, schema: Mapping[str, Any]) -> list[InputError]:
    """Faults that pydantic found in plain data, each under its own field.

    Names that were probably meant are those of a JSON Schema of what the data should be.
    """
    every = (schema, *schema.get("$defs", {}).values())
    sections = [section["properties"] for section in every if "properties" in section]
    found: dict[str, InputError] = {}
    for detail in error.errors(include_url=False):
        for fault in _faults_of(detail, data, sections):
            before = found.setdefault(fault.field, fault)
            if fault.allowed not in before.allowed.split(", or "):  # another form of the field
                allowed = f"{before.allowed}, or {fault.allowed}"
                found[fault.field] = InputError(fault.field, fault.value, allowed)
    # Of a field of several forms what is wrong within one says more than that it is no other.
    within = {field: any(other.startswith(f"{field}.") for other in found) for field in found}
    return [fault for field, fault in found.items() if not within[field]]


def _faults_of(detail: Mapping[str, Any], data: Any, sections: _Sections) -> Iterator[InputError]:
    """One error of pydantic."""
    kind, value, (place, parent) = detail["type"], detail["input"], _place(detail, data)
    names = [name for section in sections for name in section]
    context = detail.get("ctx", {})
    cause, name = context.get("error"), detail["loc"][-1] if detail["loc"] else ""
    given = value if isinstance(value, Mapping) else {}
    match kind:
        case _ if isinstance(cause, InputError):
            yield InputError(_joined(place, cause.field, given), cause.value, cause.allowed)
            return
        case _ if isinstance(cause, ValueError):
            allowed = str(cause)
        case "unexpected_keyword_argument" | "extra_forbidden":
            siblings = _siblings(parent, name, sections)
            there = f"; there are {', '.join(siblings)}" if siblings else ""
            meant = did_you_mean(name, siblings or names)
            allowed = f"no such field; remove it or mend its name{there}{meant}"
        case "missing" | "missing_argument" if isinstance(name, int):
            place, allowed = place.rpartition(".")[0], f"at least {name + 1} entries"
        case "missing" | "missing_argument":
            near = [each for each in given if each not in names and did_you_mean(each, [name])]
            value = None
            allowed = "field required" + (f"; is it meant by {near[0]!r}?" if near else "")
        case "union_tag_invalid" | "union_tag_not_found":
            tag = context["discriminator"].strip("'")
            value, place = given.get(tag), f"{place}.{tag}"
            kinds = [each[tag]["const"] for each in sections if "const" in each.get(tag, {})]
            tags = context.get("expected_tags", "").split("'")[1::2] or kinds
            needed = "" if value else "needed: "
            allowed = f"{needed}one of {', '.join(tags)}{did_you_mean(value, tags)}"
        case "form":  # of a union whose forms are told apart by the fields that are given
            unknown = [each for each in given if each not in names]
            allowed = detail["msg"] + "".join(did_you_mean(each, names) for each in unknown)
        case "literal_error":
            expected = context["expected"]
            allowed = f"{expected}{did_you_mean(value, expected.split(chr(39))[1::2])}"
        case _:
            allowed = _words(detail)
    yield InputError(place, value, allowed)


def _siblings(section: Any, wrong: Any, sections: _Sections) -> list[str]:
    """Fields of the section that this probably is: it has the others, and one of a like name."""
    others = set(section) - {wrong} if isinstance(section, Mapping) else set()
    fitting = [list(names) for names in sections if others <= set(names)] if others else []
    return min(fitting, key=lambda names: (not did_you_mean(wrong, names), len(names)), default=[])


def _words(detail: Mapping[str, Any]) -> str:
    kind = _KINDS.get(detail["type"].partition("_")[0])
    if kind is not None and detail["type"].endswith(("_type", "_from_float", "_exact_type")):
        quoted = isinstance(detail["input"], str) and kind not in ("a list", "a table")
        return f"{kind}, without quotes" if quoted else kind
    if detail["type"] == "too_long":
        return f"{detail['ctx']['max_length']} entries"
    words = detail["msg"][0].lower() + detail["msg"][1:]
    return words.removeprefix("input should be ")


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
    return ".".join(place) or "scene", parent


def _joined(place: str, field: str, given: Mapping[str, Any]) -> str:
    """Path of a field of a section, which names itself in front of its fields or does not."""
    if place == "scene":
        return field
    first, _, rest = field.partition(".")
    return f"{place}.{rest if rest and first not in given else field}"
