"""What is raised when a scene is refused, and pydantic's errors as its lines.

pydantic tells of each error the path, its kind and the value. The path is made one that a person
writes, and names that were probably meant are added.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from cea.errors import InputError
from cea.suggestions import did_you_mean

_SHOWN = 20
"""Faults that a message tells."""
_KINDS = {
    "float": "a number",
    "int": "a whole number",
    "string": "text",
    "bool": "true or false",
    "tuple": "a list",
    "list": "a list",
    "dict": "a table",
    "dataclass": "a table",
}
"""Kinds of values by the first word of pydantic's types of errors."""
_UNKNOWN = ("unexpected_keyword_argument", "extra_forbidden")
_MISSING = ("missing", "missing_argument")

Node = Mapping[str, Any]
Part = str | int


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


def problems(error: ValidationError, data: Any, schema: Node) -> list[InputError]:
    """Faults that pydantic found, each under its own field."""
    found: dict[str, InputError] = {}
    for detail in error.errors(include_url=False):
        for fault in _faults_of(detail, data, schema):
            if fault.field in found:  # one of several forms the field may take
                before = found[fault.field].allowed
                if fault.allowed not in before.split(", or "):
                    allowed = f"{before}, or {fault.allowed}"
                    found[fault.field] = InputError(fault.field, fault.value, allowed)
            else:
                found[fault.field] = fault
    # Of a field of several forms what is wrong within one says more than that it is no other.
    return [
        fault
        for field, fault in found.items()
        if not any(other.startswith(f"{field}.") for other in found)
    ]


def _faults_of(detail: Mapping[str, Any], data: Any, schema: Node) -> Iterator[InputError]:
    """One error of pydantic; of those that a section tells of itself, each."""
    kind, value, place = detail["type"], detail["input"], _place(detail, data, schema)
    known = _names(schema, detail["loc"])
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        for each in (cause, *cause.others):
            yield InputError(_joined(place, each.field, known), each.value, each.allowed)
        return
    siblings = _names(schema, detail["loc"][:-1])
    name = detail["loc"][-1] if detail["loc"] else ""
    if kind in _UNKNOWN:
        there = f"; there are {', '.join(siblings)}" if siblings else ""
        meant = did_you_mean(name, siblings)
        allowed = f"no such field; remove it or mend its name{there}{meant}"
    elif kind in _MISSING and isinstance(name, int):
        lists = _below(schema, detail["loc"][:-1])
        length = next((node["minItems"] for node in lists if "minItems" in node), name + 1)
        place, allowed = place.rpartition(".")[0], f"{length} entries"
    elif kind in _MISSING:
        given = value if isinstance(value, Mapping) else {}
        near = [each for each in given if each not in siblings and did_you_mean(each, [name])]
        value, allowed = None, "field required"
        allowed += f"; is it meant by {near[0]!r}?" if near else ""
    elif kind in ("union_tag_invalid", "union_tag_not_found"):
        tag = str(detail["ctx"]["discriminator"]).strip("'")
        tags = _tags(schema, detail["loc"])
        value = value.get(tag) if isinstance(value, Mapping) else value
        place = f"{place}.{tag}"
        needed = "needed: " if kind.endswith("not_found") else ""
        allowed = f"{needed}one of {', '.join(tags)}{did_you_mean(value, tags)}"
    elif kind == "form":  # of a union whose forms are told apart by the fields that are given
        given = value if isinstance(value, Mapping) else {}
        meant = "".join(did_you_mean(each, _names(schema, detail["loc"])) for each in given)
        allowed = f"{detail['msg']}{meant}"
    elif kind == "literal_error":
        expected = detail["ctx"]["expected"]
        allowed = f"{expected}{did_you_mean(value, expected.split(chr(39))[1::2])}"
    else:
        allowed = str(cause) if isinstance(cause, ValueError) else _words(detail)
    yield InputError(place, value, allowed)


def _words(detail: Mapping[str, Any]) -> str:
    """Any other error, in pydantic's words but for kinds of values."""
    kind = _KINDS.get(detail["type"].partition("_")[0])
    if kind is not None and detail["type"].endswith(("_type", "_from_float", "_exact_type")):
        return f"{kind}, without quotes" if _is_quoted(detail["input"], kind) else kind
    if detail["type"] == "too_long":
        return f"{detail['ctx']['max_length']} entries"
    words = detail["msg"][0].lower() + detail["msg"][1:]
    return words.removeprefix("input should be ")


def _is_quoted(value: Any, kind: str) -> bool:
    """Whether a value is a number or a truth value in quotes."""
    if not isinstance(value, str):
        return False
    if kind == _KINDS["bool"]:
        return value.strip().lower() in ("true", "false")
    try:
        float(value)
    except ValueError:
        return False
    return "number" in kind


def _place(detail: Mapping[str, Any], data: Any, schema: Node) -> str:
    """Path of a field as a person writes it: pydantic's without the names of forms."""
    place: list[Part] = []
    nodes = _forms(schema, [schema])
    for part in detail["loc"]:
        in_list = isinstance(data, list) and isinstance(part, int) and part < len(data)
        there = in_list or (isinstance(data, Mapping) and part in data)
        if there and not _of_kind(nodes, part):
            place.append(part)
            data = data[part]
        nodes = _step(schema, nodes, part)
    if detail["type"] in _MISSING:
        place.append(detail["loc"][-1])
    return ".".join(map(str, place)) or "scene"


def _joined(place: str, field: str, known: Sequence[str]) -> str:
    """Path of a field of a section, which names itself in front of its fields or does not."""
    if place == "scene":
        return field
    return f"{place}.{field if field.split('.')[0] in known else field.split('.')[-1]}"


def _names(schema: Node, place: Sequence[Part]) -> list[str]:
    """Names of the fields of a section; none where its names are free."""
    nodes = _below(schema, place)
    return list(dict.fromkeys(name for node in nodes for name in node.get("properties", {})))


def _tags(schema: Node, place: Sequence[Part]) -> list[str]:
    """Kinds that the section at a place may say it is."""
    tags = [
        value
        for node in _below(schema, place)
        for field in node.get("properties", {}).values()
        if (value := field.get("const")) is not None
    ]
    return list(dict.fromkeys(tags))


def _below(schema: Node, place: Sequence[Part]) -> list[Node]:
    """Every form that a schema has at a place."""
    nodes = _forms(schema, [schema])
    for part in place:
        nodes = _step(schema, nodes, part)
    return nodes


def _step(schema: Node, nodes: list[Node], part: Part) -> list[Node]:
    """Forms below some forms; a part that names one of them chooses it, or nothing."""
    if chosen := _of_kind(nodes, part):
        return chosen
    found: list[Node] = []
    for node in nodes:
        properties, others = node.get("properties", {}), node.get("additionalProperties")
        items = node.get("prefixItems", [])
        if part in properties:
            found.append(properties[part])
        elif isinstance(part, str) and isinstance(others, Mapping):
            found.append(others)
        elif isinstance(part, int) and isinstance(node.get("items"), Mapping):
            found.append(node["items"])
        elif isinstance(part, int) and part < len(items):
            found.append(items[part])
    return _forms(schema, found) if found else nodes


def _of_kind(nodes: list[Node], part: Part) -> list[Node]:
    """Of sections of several kinds that of a name."""
    if len(nodes) < 2:
        return []
    return [
        node
        for node in nodes
        if any(each.get("const") == part for each in node.get("properties", {}).values())
    ]


def _forms(schema: Node, nodes: Iterable[Node]) -> list[Node]:
    """Every form of some nodes, resolved."""
    found: list[Node] = []
    for node in nodes:
        while "$ref" in node:
            node = schema["$defs"][node["$ref"].rpartition("/")[2]]
        inner = node.get("oneOf") or node.get("anyOf")
        found += _forms(schema, inner) if inner else [node]
    return found
