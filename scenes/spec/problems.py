"""Faults that pydantic finds in a scene, in the words of those who write scenes."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from cea.errors import InputError
from cea.suggestions import did_you_mean
from scenes.spec.field_tree import FieldTree, Part

_SHOWN = 20
"""Faults that a message tells."""


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


_FREE = FieldTree({})
"""Of what has no schema: nothing is known of its fields."""
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


def faults_told_by(error: ValidationError, tree: FieldTree = _FREE) -> list[InputError]:
    """Faults that pydantic found, each under its own field.

    Parameters
    ----------
    error
        What pydantic raised.
    tree
        The fields there are, for what was probably meant, and for paths without the names of forms.
    """
    faults: dict[str, InputError] = {}
    for detail in _by_form(error.errors(include_url=False), tree):
        for fault in _faults_of(detail, tree):
            if fault.field in faults:  # one of several forms the field may take
                before = faults[fault.field].allowed
                if fault.allowed in before.split(", or "):
                    continue
                fault = InputError(fault.field, fault.value, f"{before}, or {fault.allowed}")
            faults[fault.field] = fault
    return list(faults.values())


def _faults_of(detail: Mapping[str, Any], tree: FieldTree) -> Iterable[InputError]:
    """One fault that pydantic found; of those that a section tells of itself, each."""
    cause = detail.get("ctx", {}).get("error")
    place = dotted(tree.written(detail["loc"]))
    if isinstance(cause, InputError):
        for each in (cause, *cause.others):
            known = tree.names(detail["loc"])
            yield InputError(_joined(place, each.field, known), each.value, each.allowed)
    elif isinstance(cause, ValueError):
        yield InputError(place, detail["input"], str(cause))
    else:
        telling = _TELLING.get(detail["type"], _told_by_pydantic)
        yield telling(place, detail, tree)


def dotted(path: Iterable[Part]) -> str:
    """A path as messages name it."""
    return ".".join(map(str, path)) or "scene"


def _joined(place: str, field: str, known: Sequence[str]) -> str:
    """Path of a field of a section, which names itself in front of its fields or does not."""
    if place == "scene":
        return field
    return f"{place}.{field if field.split('.')[0] in known else field.split('.')[-1]}"


def _by_form(details: Sequence[Any], tree: FieldTree) -> Iterable[Mapping[str, Any]]:
    """Faults of each field; of a table that may have several forms, those of the form meant.

    That is the form of which nothing is missing; where each misses something, all of them are told
    as one fault of the table.
    """
    by_table: dict[tuple[Part, ...], dict[Part, list[Any]]] = {}
    for detail in details:
        if (split := _split(detail["loc"], tree)) is not None:
            table, form = split
            by_table.setdefault(table, {}).setdefault(form, []).append(detail)
        else:
            yield detail
    for table, forms in by_table.items():
        whole = [form for form in forms.values() if not any(map(_lacks_a_field, form))]
        if whole:
            yield from min(whole, key=len)
            continue
        needed = [
            "{" + ", ".join(f"{d['loc'][-1]} = ..." for d in found if _lacks_a_field(d)) + "}"
            for found in forms.values()
        ]
        first = next(iter(forms.values()))
        given = next((d["input"] for d in first if _lacks_a_field(d)), None)
        unknown = [d["loc"][-1] for d in first if d["type"] in _UNKNOWN]
        meant = "".join(did_you_mean(name, tree.names(table)) for name in unknown)
        yield {
            "type": "form",
            "loc": table,
            "input": given,
            "msg": f"one of {', '.join(needed)}{meant}",
        }


def _lacks_a_field(detail: Mapping[str, Any]) -> bool:
    """Whether a field is missing, not an entry of a list."""
    return detail["type"] == "missing" and isinstance(detail["loc"][-1], str)


def _split(place: Sequence[Part], tree: FieldTree) -> tuple[tuple[Part, ...], Part] | None:
    """Place of a table of several forms that a field stands in, and the form; None elsewhere."""
    for i, part in enumerate(place[:-1]):
        form_alone = len(tree.written(place[: i + 1])) == len(tree.written(place[:i]))
        if form_alone and isinstance(part, str) and not tree.tagged(place[:i]):
            return tuple(place[:i]), part
    return None


_UNKNOWN = ("unexpected_keyword_argument", "extra_forbidden")


def _unknown(place: str, detail: Mapping[str, Any], tree: FieldTree) -> InputError:
    """A field that is not there."""
    name, known = detail["loc"][-1], tree.names(detail["loc"][:-1])
    there = f"; there are {', '.join(known)}" if known else ""
    allowed = f"no such field; remove it or mend its name{there}{did_you_mean(name, known)}"
    return InputError(place, detail["input"], allowed)


def _missing(place: str, detail: Mapping[str, Any], tree: FieldTree) -> InputError:
    """A field that must be there, or an entry of a list of fixed length."""
    if isinstance(detail["loc"][-1], int):
        length = tree.length(detail["loc"][:-1])
        return InputError(place.rpartition(".")[0], detail["input"], f"{length} entries")
    known = tree.names(detail["loc"][:-1])
    given = detail["input"] if isinstance(detail["input"], Mapping) else {}
    name = detail["loc"][-1]
    near = [each for each in given if each not in known and did_you_mean(each, [name])]
    instead = f"; is it meant by {near[0]!r}?" if near else ""
    return InputError(place, None, f"field required{instead}")


def _choice(place: str, detail: Mapping[str, Any], tree: FieldTree) -> InputError:
    """One of a few words that is none of them."""
    expected = detail["ctx"]["expected"]
    known = expected.split("'")[1::2]
    return InputError(place, detail["input"], f"{expected}{did_you_mean(detail['input'], known)}")


def _kind(place: str, detail: Mapping[str, Any], tree: FieldTree) -> InputError:
    """A section of a kind that is not there."""
    name = detail["ctx"]["discriminator"].strip("'")
    known = detail["ctx"]["expected_tags"].split("'")[1::2]
    tag = detail["ctx"]["tag"]
    allowed = f"one of {', '.join(known)}{did_you_mean(tag, known)}"
    return InputError(f"{place}.{name}", detail["input"].get(name, tag), allowed)


def _no_kind(place: str, detail: Mapping[str, Any], tree: FieldTree) -> InputError:
    """A section that does not say of which kind it is."""
    name = detail["ctx"]["discriminator"].strip("'")
    return InputError(
        f"{place}.{name}", None, f"needed: one of {', '.join(tree.tags(detail['loc']))}"
    )


def _told_by_pydantic(place: str, detail: Mapping[str, Any], tree: FieldTree) -> InputError:
    """Any other fault."""
    value, words = detail["input"], detail["msg"][0].lower() + detail["msg"][1:]
    kind = _KINDS.get(detail["type"].partition("_")[0])
    if kind is not None and detail["type"].endswith(("_type", "_from_float", "_exact_type")):
        words = f"{kind}, without quotes" if _is_quoted(value, kind) else kind
    elif detail["type"] == "too_long" and (length := tree.length(detail["loc"])) is not None:
        words = f"{length} entries"
    return InputError(place, value, words.removeprefix("input should be "))


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


_TELLING: dict[str, Callable[[str, Mapping[str, Any], FieldTree], InputError]] = {
    **dict.fromkeys(_UNKNOWN, _unknown),
    "missing": _missing,
    "missing_argument": _missing,
    "literal_error": _choice,
    "union_tag_invalid": _kind,
    "union_tag_not_found": _no_kind,
}
"""What tells faults, by pydantic's type of error."""
