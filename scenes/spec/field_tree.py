"""The fields that scenes can have, found by their paths in the JSON Schema of a scene."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Node = Mapping[str, Any]
Part = str | int

_TYPES = {"str": "string", "float": "number", "int": "integer", "bool": "boolean"}
"""Names that pydantic gives to plain forms of a field, as JSON Schema has them."""

_LISTS = ("tuple[", "list[")
"""Beginnings of the names of those that are lists."""


@dataclass(frozen=True)
class FieldTree:
    """The tree of the fields of a kind of scene.

    Parameters
    ----------
    schema
        Its JSON Schema, as pydantic makes it.
    """

    schema: Node

    def written(self, place: Sequence[Part]) -> tuple[Part, ...]:
        """Path of a field as a person writes it: without the forms that pydantic tells.

        Parameters
        ----------
        place
            Where pydantic found a fault: below a field of several forms stands the form's name.
        """
        nodes, parts = [self.schema], []
        for part in place:
            nodes, is_form = self._below(nodes, part)
            if not is_form:
                parts.append(part)
        return tuple(parts)

    def names(self, place: Sequence[Part]) -> tuple[str, ...]:
        """Names of the fields of a section; none where its names are free.

        Parameters
        ----------
        place
            Path of the section, with forms as pydantic tells them, or without.
        """
        nodes = self._at(place)
        every = [name for node in self._forms(nodes) for name in node.get("properties", {})]
        return tuple(dict.fromkeys(every))

    def tagged(self, place: Sequence[Part]) -> bool:
        """Whether the section at a place says itself of which of several kinds it is."""
        return bool(self.tags(place))

    def tags(self, place: Sequence[Part]) -> tuple[str, ...]:
        """Kinds that the section at a place may say it is; none where there is one."""
        of_kinds = [n for n in map(self._resolved, self._at(place)) if "discriminator" in n]
        return tuple(tag for node in of_kinds for tag in node["discriminator"]["mapping"])

    def length(self, place: Sequence[Part]) -> int | None:
        """Entries of a list of fixed length; None of any other."""
        lengths = [node.get("maxItems") for node in self._forms(self._at(place))]
        return next((length for length in lengths if length is not None), None)

    def _at(self, place: Sequence[Part]) -> list[Node]:
        """What may stand at a place."""
        nodes = [self.schema]
        for part in place:
            nodes, _ = self._below(nodes, part)
        return nodes

    def _below(self, nodes: Sequence[Node], part: Part) -> tuple[list[Node], bool]:
        """What stands below some nodes, and whether the part of the path names a form alone."""
        chosen = [form for node in nodes for form in self._named(self._resolved(node), part)]
        if chosen:
            return chosen, True
        found: list[Node] = []
        for node in self._forms(nodes):
            properties, others = node.get("properties", {}), node.get("additionalProperties")
            items = node.get("prefixItems", [])
            if isinstance(part, str) and part in properties:
                found.append(properties[part])
            elif isinstance(part, str) and isinstance(others, Mapping):
                found.append(others)
            elif isinstance(part, int) and isinstance(node.get("items", False), Mapping):
                found.append(node["items"])
            elif isinstance(part, int) and part < len(items):
                found.append(items[part])
        return found, False

    def _named(self, node: Node, part: Part) -> list[Node]:
        """Form of a node that has a name; of a node of one form none."""
        if "discriminator" in node:
            mapping = node["discriminator"]["mapping"]
            return [{"$ref": mapping[part]}] if part in mapping else []
        forms = [form for form in node.get("anyOf", ()) if form.get("type") != "null"]
        if len(forms) < 2 or not isinstance(part, str):
            if len(forms) == 1:
                return self._named(self._resolved(forms[0]), part)
            return []
        kind = "array" if part.startswith(_LISTS) else _TYPES.get(part, part)
        return [f for f in forms if kind in (f.get("type"), self._resolved(f).get("title"))]

    def _forms(self, nodes: Sequence[Node]) -> Iterator[Node]:
        """Every form of some nodes, resolved."""
        for node in map(self._resolved, nodes):
            inner = node.get("oneOf") or node.get("anyOf")
            if inner:
                yield from self._forms(inner)
            else:
                yield node

    def _resolved(self, node: Node) -> Node:
        """What a node refers to."""
        while "$ref" in node:
            node = self.schema["$defs"][node["$ref"].rpartition("/")[2]]
        return node
