"""The field reference of scenes: every section and field as Markdown, made of the schema."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from scenes.spec.schema import Kind, scene_schema, type_in_words

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
_ROOTS: dict[Kind, str] = {"bodies": "scene", "matrices": "scene of matrices"}


def reference_text() -> str:
    """The reference, ending with a line break."""
    lines, told = [_HEAD], set[str]()
    for kind, root in _ROOTS.items():
        schema = scene_schema(kind)
        lines.append(f"\n## Scenes of {kind}\n")
        for name, section in {root: schema, **schema["$defs"]}.items():
            if name not in told:
                told.add(name)
                lines += _section(name, section)
    return "\n".join(lines).rstrip() + "\n"


def _section(name: str, section: Mapping[str, Any]) -> Iterator[str]:
    """Lines of a section."""
    which = [
        f'`{field} = "{spec["const"]}"`. '
        for field, spec in section["properties"].items()
        if "const" in spec
    ]
    yield f"### {name}\n"
    yield f"{''.join(which)}{_cell(section['description'])}\n"
    fields = {n: spec for n, spec in section["properties"].items() if "const" not in spec}
    if fields:
        yield "| field | type | default | meaning |"
        yield "|---|---|---|---|"
    for field, spec in fields.items():
        value = spec.get("default")
        default = "" if value in (None, [], {}, "") else f"`{json.dumps(value)}`"
        default = "needed" if field in section.get("required", ()) else default
        meaning = _cell(spec.get("description", ""))
        yield f"| `{field}` | {type_in_words(spec)} | {default} | {meaning} |"
    yield ""


def _cell(text: str) -> str:
    """Text that no mark of a table, and none of Markdown, is read into."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("_", "\\_")
