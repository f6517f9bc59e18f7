"""The field reference of scenes: every section and field as Markdown, made of the schema."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from scenes.spec.schema import Kind, scene_schema

Node = Mapping[str, Any]

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
_TITLES: dict[Kind, str] = {"bodies": "Scenes of bodies", "matrices": "Scenes of matrices"}
_ROOTS: dict[Kind, str] = {"bodies": "scene", "matrices": "scene of matrices"}
_BOUNDS = {
    "minimum": "≥ {}",
    "exclusiveMinimum": "> {}",
    "maximum": "≤ {}",
    "exclusiveMaximum": "< {}",
}


def reference_text() -> str:
    """The reference, ending with a line break."""
    lines, told = [_HEAD], set[str]()
    for kind, title in _TITLES.items():
        schema = scene_schema(kind)
        lines.append(f"\n## {title}\n")
        for name, place, section in _sections(schema, _ROOTS[kind]):
            if name not in told:
                told.add(name)
                lines += _section(name, place, section)
    return "\n".join(lines).rstrip() + "\n"


def _sections(schema: Node, root: str) -> Iterator[tuple[str, str, Node]]:
    """Name of every section as shown, path where it first stands, and what it is."""
    yield root, "", schema
    seen: set[str] = set()
    level = [("", schema)]
    while level:
        inner: list[tuple[str, Node]] = []
        for place, section in level:
            for field, spec in section.get("properties", {}).items():
                for name, below in _referred(spec, f"{place}.{field}".lstrip(".")):
                    if name not in seen:
                        seen.add(name)
                        inner.append((below, schema["$defs"][name]))
                        yield name, below, schema["$defs"][name]
        level = inner


def _referred(node: Any, place: str) -> Iterator[tuple[str, str]]:
    """Names of the sections that a part of a schema refers to, each with its path."""
    if isinstance(node, list):
        for part in node:
            yield from _referred(part, place)
    if not isinstance(node, Mapping):
        return
    if "$ref" in node:
        yield _name(node["$ref"]), place
    for key, below in (("additionalProperties", ".NAME"), ("items", "[0]")):
        yield from _referred(node.get(key), place + below)
    for key in ("anyOf", "oneOf", "prefixItems"):
        yield from _referred(node.get(key), place)


def _name(reference: str) -> str:
    return reference.rpartition("/")[2]


def _section(name: str, place: str, section: Node) -> Iterator[str]:
    """Lines of a section."""
    needed = section.get("required", ())
    which = [
        f"{field} = {spec['const']!r}".replace("'", '"')
        for field, spec in section["properties"].items()
        if "const" in spec
    ]
    yield f"### {name}\n"
    where = ", with ".join([*([f"`{place}`"] if place else []), *(f"`{each}`" for each in which)])
    yield f"{f'At {where}. ' if where else ''}{_cell(section['description'])}\n"
    fields = {n: spec for n, spec in section["properties"].items() if "const" not in spec}
    if not fields:
        return
    yield "| field | type | default | meaning |"
    yield "|---|---|---|---|"
    for field, spec in fields.items():
        default = "needed" if field in needed else _default(spec)
        yield f"| `{field}` | {_type(spec)} | {default} | {_cell(spec.get('description', ''))} |"
    yield ""


def _cell(text: str) -> str:
    """Text that no mark of a table, and none of Markdown, is read into."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("_", "\\_")


def _default(spec: Node) -> str:
    """Default of a field that may be left out."""
    value = spec.get("default")
    if value is None or value == [] or value == {} or value == "":
        return ""
    return f"`{json.dumps(value)}`"


def _type(spec: Node) -> str:
    """Type of a field in words."""
    if "$ref" in spec:
        name = _name(spec["$ref"])
        return f"[{name}](#{name.lower()})"
    for forms in ("anyOf", "oneOf"):
        if forms in spec:
            return " or ".join(dict.fromkeys(map(_type, spec[forms])))
    if "enum" in spec:
        return ", ".join(f'`"{word}"`' for word in spec["enum"])
    if "const" in spec:
        return f'`"{spec["const"]}"`'
    kind = spec.get("type")
    if kind == "array":
        return _list(spec)
    if kind == "object":
        others = spec.get("additionalProperties")
        return f"table by name: {_type(others)}" if isinstance(others, Mapping) else "table"
    words = {"number": "number", "integer": "whole number", "string": "text", "boolean": "truth"}
    bounds = [words_of.format(spec[b]) for b, words_of in _BOUNDS.items() if b in spec]
    return " ".join([words.get(str(kind), "any value"), *([", ".join(bounds)] if bounds else [])])


def _list(spec: Node) -> str:
    """Type of a list in words."""
    length = spec.get("maxItems")
    item: Node = spec.get("items") or next(iter(spec.get("prefixItems", [])), {})
    kind = _type(item)
    many = f"{kind}s" if kind in ("number", "whole number") else kind
    return f"list of {f'{length} ' if length else ''}{many}"
