"""The JSON Schema of scenes: what pydantic makes of the dataclasses, with their documentation.

Editors complete and check scene files with it; the field reference is made of it.
"""

import json
import re
from collections.abc import Mapping
from functools import cache
from inspect import cleandoc
from typing import Any, Literal

from pydantic import TypeAdapter

from scenes.spec.matrices import MatrixScene
from scenes.spec.scene import SceneSpec

Kind = Literal["bodies", "matrices"]

_KINDS: dict[Kind, tuple[type, str]] = {
    "bodies": (SceneSpec, "scene.schema.json"),
    "matrices": (MatrixScene, "matrix_scene.schema.json"),
}
"""Class of a kind of scene, and the file in docs/."""
_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_SAYS_WHICH = {"shape": "geometry", "method": "formulation", "kind": "analysis"}
"""Fields that say of which kind a section is."""


def schema_file(kind: Kind) -> str:
    """Name of the file of a schema in ``docs``."""
    return _KINDS[kind][1]


def schema_text(kind: Kind) -> str:
    """The schema of a kind of scene as a file holds it."""
    return json.dumps(scene_schema(kind), indent=1, ensure_ascii=False) + "\n"


@cache
def scene_schema(kind: Kind) -> dict[str, Any]:
    """The schema of a kind of scene: each section with its summary, each field with its meaning."""
    made = _KINDS[kind][0]
    schema = TypeAdapter(made).json_schema()
    schema["description"] = cleandoc(made.__doc__ or "")
    schema["title"] = f"scene of {kind}"
    for section in (schema, *schema.get("$defs", {}).values()):
        _document(section)
    return {"$schema": _DIALECT, **_without_null(schema)}


def _without_null(node: Any) -> Any:
    """A schema in which nothing may be null: TOML has no such value, fields are left out."""
    if isinstance(node, list):
        return [_without_null(part) for part in node]
    if not isinstance(node, dict):
        return node
    node = {name: _without_null(part) for name, part in node.items()}
    if "anyOf" in node:
        forms = [form for form in node.pop("anyOf") if form != {"type": "null"}]
        node |= {"anyOf": forms} if len(forms) > 1 else forms[0]
    if node.get("default", ...) is None:
        del node["default"]
    return node


def _document(section: dict[str, Any]) -> None:
    """Take what the docstring of a section says of its fields to the fields."""
    summary, _, rest = section.get("description", "").partition("\n\nParameters\n")
    section["description"] = _plain(re.split(r"\n\n\w+\n-{3,}\n", summary)[0])
    meanings: dict[str, str] = {}
    fields = re.split(r"\n\n\w+\n-{3,}\n", rest.partition("\n")[2])[0]
    for entry in re.split(r"\n(?=\S)", fields.strip("\n")):
        names, _, text = entry.partition("\n")
        meanings |= {name.strip(): _plain(text) for name in names.partition(" : ")[0].split(",")}
    for name, field in section.get("properties", {}).items():
        field.pop("title", None)
        meaning = meanings.get(name)
        if meaning is None and name in _SAYS_WHICH and "const" in field:
            meaning = f"Says which {_SAYS_WHICH[name]} it is."
        if meaning is not None:
            field["description"] = meaning


def _plain(text: str) -> str:
    """Text in one line, without the marks of docstrings."""
    text = re.sub(r":\w+:`~?([^`]*)`", r"\1", text)
    return " ".join(text.replace("``", "").split())


def type_in_words(spec: Mapping[str, Any]) -> str:
    """Type of a field in words, sections as links."""
    if "$ref" in spec:
        name = spec["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    for forms in ("anyOf", "oneOf"):
        if forms in spec:
            return " or ".join(dict.fromkeys(map(type_in_words, spec[forms])))
    if "enum" in spec or "const" in spec:
        return ", ".join(f'`"{word}"`' for word in spec.get("enum", [spec.get("const")]))
    kind, others = spec.get("type"), spec.get("additionalProperties")
    if kind == "array":
        item: Mapping[str, Any] = spec.get("items") or next(iter(spec.get("prefixItems", [])), {})
        one, length = type_in_words(item), spec.get("maxItems")
        many = f"{one}s" if one in ("number", "whole number") else one
        return f"list of {f'{length} ' if length else ''}{many}"
    if kind == "object":
        return f"table by name: {type_in_words(others)}" if isinstance(others, Mapping) else "table"
    words = {"number": "number", "integer": "whole number", "string": "text", "boolean": "truth"}
    bounds = [sign + str(spec[bound]) for bound, sign in _BOUNDS.items() if bound in spec]
    return " ".join([words.get(str(kind), "any value"), *([", ".join(bounds)] if bounds else [])])


_BOUNDS = {"minimum": "≥ ", "exclusiveMinimum": "> ", "maximum": "≤ ", "exclusiveMaximum": "< "}
