"""Content of a deck: its nodes and elements as they are, or those of the instances of parts."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from cea.errors import InputError, require
from meshes.files.abaqus.deck import Floats, Ints, keywords_of
from meshes.files.abaqus.scope import Members, Scope
from meshes.files.content import ElementBlock, FileContent, known_rows
from meshes.files.kinds import FACES

_DEEPEST = 20
"""Sets that are members of one another."""


@dataclass
class _Instance:
    """A part put in place."""

    name: str
    part: str
    placing: list[list[str]] = field(default_factory=list)
    own: Scope = field(default_factory=Scope)


@dataclass(eq=False)
class _Place:
    """Where the nodes and elements of one instance stand in the content."""

    scope: Scope
    numbers: Ints
    first_node: int
    element_numbers: Ints
    first_element: int


def abaqus_content(file: Path) -> FileContent:
    """Nodes, elements, sets and surfaces of a deck.

    Sets and surfaces of parts have the name they have there, those of several instances together;
    and, behind the name of the instance and a dot, those of each. All elements of an instance are a
    set by its name.

    Raises
    ------
    InputError
        When it is not as the format has it.
    """
    flat, parts, instances = _scopes(file)
    if not instances:
        instances = [_Instance(name, name) for name in parts]
    blocks: list[ElementBlock] = []
    points: list[Floats] = []
    numbers: list[Ints] = []
    places: dict[str, _Place] = {}
    for instance in [_Instance("", ""), *instances]:
        scope = _scope_of(instance, flat, parts)
        own_numbers, positions = scope.numbered()
        first_node, first_element = sum(map(len, points)), sum(map(len, blocks))
        own = [
            replace(b, nodes=np.where(b.nodes < 0, -1, b.nodes + first_node))
            for b in scope.blocks(own_numbers)
        ]
        elements = [np.empty(0, dtype=np.int64), *(b.numbers for b in own)]
        name = instance.name.upper()
        places[name] = _Place(
            scope, own_numbers, first_node, np.concatenate(elements), first_element
        )
        points.append(_placed(positions, instance))
        numbers.append(own_numbers)
        blocks += own
    require(sum(map(len, points)) > 0, "file", "no nodes", "a deck with *NODE and *ELEMENT")
    content = FileContent(np.concatenate(points), np.concatenate(numbers), blocks)
    return _with_sets(content, places, {i.name.upper(): i.name for i in instances})


def _scopes(file: Path) -> tuple[Scope, dict[str, Scope], list[_Instance]]:
    """What stands outside of parts, each part, and the instances of parts."""
    flat, parts, instances = Scope(), dict[str, Scope](), list[_Instance]()
    inside = flat
    for keyword in keywords_of(file):
        match keyword.name:
            case "PART":
                inside = parts.setdefault(keyword.needed("NAME").upper(), Scope())
            case "INSTANCE":
                part = keyword.needed("PART")
                new = _Instance(keyword.needed("NAME"), part.upper(), keyword.lines)
                instances.append(new)
                inside = new.own
            case "END PART" | "END INSTANCE" | "ASSEMBLY" | "END ASSEMBLY":
                inside = flat
            case "STEP":
                return flat, parts, instances  # from here on it says what is done
            case _:
                inside.take(keyword)
    return flat, parts, instances


def _scope_of(instance: _Instance, flat: Scope, parts: Mapping[str, Scope]) -> Scope:
    if not instance.name:
        return flat
    known = ", ".join(parts) or "none"
    require(instance.part in parts, "file", f"*INSTANCE, PART={instance.part}", f"one of {known}")
    part, own = parts[instance.part], instance.own
    return Scope(
        [*part.nodes, *own.nodes],
        [*part.elements, *own.elements],
        {**part.node_sets, **own.node_sets},
        {**part.element_sets, **own.element_sets},
        {**part.surfaces, **own.surfaces},
    )


def _placed(points: Floats, instance: _Instance) -> Floats:
    """Points of a part where its instance stands: shifted, then turned about an axis."""
    try:
        lines = [[float(each) for each in line if each] for line in instance.placing]
    except ValueError:
        lines = [[]]
    allowed = "a line of a translation, and one of two points of an axis and an angle"
    sizes = [len(line) for line in lines]
    require(sizes in ([], [3], [3, 7]), "file", f"*INSTANCE, NAME={instance.name}", allowed)
    if sizes:
        points = points + lines[0]
    if len(sizes) > 1:
        start, end, angle = np.array(lines[1][:3]), np.array(lines[1][3:6]), lines[1][6]
        axis = end - start
        require(bool(np.any(axis)), "file", f"*INSTANCE, NAME={instance.name}", allowed)
        turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis), degrees=True)
        points = start + turn.apply(points - start)
    return points


def _with_sets(
    content: FileContent, places: Mapping[str, _Place], names: Mapping[str, str]
) -> FileContent:
    """The content with sets of nodes, of elements and of faces."""
    found = _Sets({}, {}, {})
    for key, place in places.items():
        resolver = _Resolver(content, places, key)
        own = _Sets(
            {n: resolver.members("node", n) for n in place.scope.node_sets},
            {n: resolver.members("element", n) for n in place.scope.element_sets},
            {},
        )
        for name, (kind, lines) in place.scope.surfaces.items():
            if kind == "NODE":
                nodes = [resolver.entry("node", line[0]) for line in lines]
                own.nodes[name] = _joined(nodes)
            elif kind == "ELEMENT":
                own.faces[name] = resolver.faces(lines)
        found.add(own, "")
        if key:
            everything = place.first_element + np.arange(len(place.element_numbers))
            found.add(own, f"{names[key]}.")
            found.elements.setdefault(names[key], everything)
    return replace(
        content, node_sets=found.nodes, element_sets=found.elements, face_sets=found.faces
    )


@dataclass
class _Sets:
    """Sets by kind and name."""

    nodes: dict[str, Ints]
    elements: dict[str, Ints]
    faces: dict[str, Ints]

    def add(self, other: "_Sets", before: str) -> None:
        """Add sets under names with something before them; those of one name together."""
        for mine, theirs in (
            (self.nodes, other.nodes),
            (self.elements, other.elements),
            (self.faces, other.faces),
        ):
            for name, members in theirs.items():
                key = before + name
                mine[key] = np.concatenate([mine[key], members]) if key in mine else members


@dataclass
class _Resolver:
    """Finds what sets of one instance, or of the assembly, have as members."""

    content: FileContent
    places: Mapping[str, _Place]
    key: str

    def members(self, kind: str, name: str, depth: int = 0) -> Ints:
        """Rows of nodes, or elements, of a set and of the sets it is made of."""
        require(depth < _DEEPEST, "file", name, f"sets inside each other up to {_DEEPEST} deep")
        place = self.places[self.key]
        sets = place.scope.node_sets if kind == "node" else place.scope.element_sets
        by_name = {each.upper(): members for each, members in sets.items()}
        instance, dot, inner = name.partition(".")
        if name.upper() not in by_name and dot and instance.upper() in self.places:
            return _Resolver(self.content, self.places, instance.upper()).members(
                kind, inner, depth + 1
            )
        require(name.upper() in by_name, "file", name, f"a set of {kind}s that the deck has")
        found = []
        for each in by_name[name.upper()]:
            found.append(self._rows(kind, each))
            inside = replace(self, key=each.instance.upper()) if each.instance else self
            found += [inside.members(kind, other, depth + 1) for other in each.names]
        return _joined(found)

    def _rows(self, kind: str, members: Members) -> Ints:
        key = members.instance.upper() or self.key
        require(key in self.places, "file", members.instance, "an instance that the deck has")
        place = self.places[key]
        all_numbers = place.numbers if kind == "node" else place.element_numbers
        first = place.first_node if kind == "node" else place.first_element
        return first + known_rows(all_numbers, members.numbers)

    def entry(self, kind: str, text: str) -> Ints:
        """Rows of a number or a set, as entries of surfaces name them."""
        if text.isdecimal() and len(text) < 16:
            return self._rows(kind, Members("", np.array([int(text)], dtype=np.int64), ()))
        return self.members(kind, text)

    def faces(self, lines: list[list[str]]) -> Ints:
        """Faces that the entries of a surface name, (n, 2)."""
        found = [np.empty((0, 2), dtype=np.int64)]
        for line in lines:
            elements = self.entry("element", line[0])
            label = line[1].upper() if len(line) > 1 else ""
            if not label:
                found.append(np.stack([elements, np.full(len(elements), -1)], axis=1))
            elif label[0] == "S" and label[1:].isdecimal() and len(label) == 2:
                found += self._numbered(elements, int(label[1:]))
        return np.concatenate(found)

    def _numbered(self, elements: Ints, number: int) -> Iterator[Ints]:
        """Faces of one number of elements of every kind."""
        for block, start in zip(self.content.blocks, self.content.starts, strict=False):
            own = elements[(elements >= start) & (elements < start + len(block))]
            if len(own) and block.cell in FACES:
                count = len(FACES[block.cell])
                allowed = f"faces S1 to S{count} of {block.kind}"
                if not 1 <= number <= count:
                    raise InputError("file", f"S{number}", allowed)
                yield np.stack([own, np.full(len(own), number - 1)], axis=1)


def _joined(parts: list[Ints]) -> Ints:
    return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *parts]))
