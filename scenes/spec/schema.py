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
from scenes.spec.reading import Scene
from scenes.spec.scene import SceneSpec

Kind = Literal["bodies", "matrices"]

_KINDS: dict[Kind, tuple[type, type, str]] = {
    "bodies": (Scene, SceneSpec, "scene.schema.json"),
    "matrices": (MatrixScene, MatrixScene, "matrix_scene.schema.json"),
}
"""Class of a kind of scene, the class that documents it, and the file in docs/."""
_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_SAYS_WHICH = {"shape": "geometry", "method": "formulation", "kind": "analysis"}
"""Fields that say of which kind a section is."""


def schema_file(kind: Kind) -> str:
    """Name of the file of a schema in ``docs``."""
    return _KINDS[kind][2]


def schema_text(kind: Kind) -> str:
    """The schema of a kind of scene as a file holds it."""
    return json.dumps(scene_schema(kind), indent=1, ensure_ascii=False) + "\n"


@cache
def scene_schema(kind: Kind) -> dict[str, Any]:
    """The schema of a kind of scene.

    Parameters
    ----------
    kind
        ``bodies`` or ``matrices``.

    Returns
    -------
    dict
        Each section with its summary, each field with its meaning as ``description``.
    """
    made, documents, _ = _KINDS[kind]
    schema = TypeAdapter(made).json_schema()
    schema["description"] = cleandoc(documents.__doc__ or "")
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
    text = section.get("description", "")
    section["description"] = summary_of(text)
    meanings = meanings_of(text)
    for name, field in section.get("properties", {}).items():
        field.pop("title", None)
        meaning = meanings.get(name)
        if meaning is None and name in _SAYS_WHICH and "const" in field:
            meaning = f"Says which {_SAYS_WHICH[name]} it is."
        if meaning is not None:
            field["description"] = meaning


def summary_of(docstring: str) -> str:
    """What a docstring says before its sections, in one line."""
    return _plain(re.split(r"\n\n\w+\n-{3,}\n", docstring, maxsplit=1)[0])


def meanings_of(docstring: str) -> Mapping[str, str]:
    """What a numpy docstring says of each parameter, in one line."""
    found = re.search(r"\nParameters\n-+\n(.*?)(?=\n\n\w+\n-{3,}\n|\Z)", docstring, re.DOTALL)
    if found is None:
        return {}
    meanings: dict[str, str] = {}
    for entry in re.split(r"\n(?=\S)", found[1].strip("\n")):
        names, _, text = entry.partition("\n")
        meanings |= {name.strip(): _plain(text) for name in names.partition(" : ")[0].split(",")}
    return meanings


def _plain(text: str) -> str:
    """Text in one line, without the marks of docstrings."""
    text = re.sub(r":\w+:`~?([^`]*)`", r"\1", text)
    return " ".join(text.replace("``", "").split())
