"""The JSON Schema of scenes, and the field reference as Markdown that is made of it.

The schema is what pydantic makes of the dataclasses, with their documentation: editors complete and
check scene files with it.
"""

import json
import re
from collections.abc import Iterator, Mapping
from functools import cache
from inspect import cleandoc
from typing import Any, Literal

from pydantic import TypeAdapter

from scenes.spec.matrices import MatrixScene
from scenes.spec.reading import Scene

Kind = Literal["bodies", "matrices"]

_KINDS: dict[Kind, type] = {"bodies": Scene, "matrices": MatrixScene}
"""Class of a kind of scene."""
_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_text(kind: Kind) -> str:
    """The schema of a kind of scene as a file holds it."""
    return json.dumps(scene_schema(kind), indent=1, ensure_ascii=False) + "\n"


@cache
def scene_schema(kind: Kind) -> dict[str, Any]:
    """The schema of a kind of scene: each section with its summary, each field with its meaning."""
    made = _KINDS[kind]
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
    summary, *rest = re.split(r"\n\n\w+\n-{3,}\n", section.get("description", ""))
    section["description"] = _plain(summary)
    meanings: dict[str, str] = {}
    for entry in re.split(r"\n(?=\S)", rest[0].strip("\n")) if rest else ():
        names, _, text = entry.partition("\n")
        meanings |= {name.strip(): _plain(text) for name in names.partition(" : ")[0].split(",")}
    for name, field in section.get("properties", {}).items():
        field.pop("title", None)
        meaning = meanings.get(name, "Says which kind it is." if "const" in field else None)
        if meaning is not None:
            field["description"] = meaning


def _plain(text: str) -> str:
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


_HEAD = """# Fields of a scene

Made by `cea scene reference` of the dataclasses that scenes are read into; a test holds it current.
A field without default is needed. Lengths are in m, angles in degrees, forces in N unless a scene
keeps other consistent units. In TOML a section is a table, `[bodies.pad.material]`, or stands in
braces, `material = { E = 8e9, nu = 0.3 }`; names of bodies and contacts are free.

`cea scene schema` prints the same as JSON Schema, which comes as `docs/scene.schema.json` (scenes
of matrices: `docs/matrix_scene.schema.json`). Editors with a TOML language server, as Even Better
TOML in VS Code or Taplo elsewhere, complete and check the fields of a file whose first line names
it, by a path from the file or by an address:

    #:schema ../docs/scene.schema.json

Fields are set on the command line by their paths, entries of lists by their number:
`--set bodies.disc.mesh.fe.elements[1]=40`, `--set 'loads[0].pressure=1e5'`.
"""


def reference_text() -> str:
    """The reference, ending with a line break."""
    lines, told = [_HEAD], set[str]()
    for kind, root in (("bodies", "scene"), ("matrices", "scene of matrices")):
        schema = scene_schema(kind)
        lines.append(f"\n## Scenes of {kind}\n")
        for name, section in {root: schema, **schema["$defs"]}.items():
            if name not in told:
                told.add(name)
                lines += _section(name, section)
    return "\n".join(lines).rstrip() + "\n"


def _section(name: str, section: Mapping[str, Any]) -> Iterator[str]:
    fields = section["properties"]
    kinds = {field: spec["const"] for field, spec in fields.items() if "const" in spec}
    which = "".join(f'`{field} = "{kind}"`. ' for field, kind in kinds.items())
    yield f"### {name}\n\n{which}{_cell(section['description'])}\n"
    if len(fields) > len(kinds):
        yield "| field | type | default | meaning |\n|---|---|---|---|"
    for field, spec in fields.items():
        if field not in kinds:
            value = spec.get("default")
            default = "" if value in (None, [], {}, "") else f"`{json.dumps(value)}`"
            default = "needed" if field in section.get("required", ()) else default
            meaning = _cell(spec.get("description", ""))
            yield f"| `{field}` | {type_in_words(spec)} | {default} | {meaning} |"
    yield ""


def _cell(text: str) -> str:
    """Text that no mark of a table, and none of Markdown, is read into."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("_", "\\_")
