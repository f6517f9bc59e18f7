"""Content of a deck of Abaqus or CalculiX: parts and their instances, sets and surfaces.

Labels ignore case. Sets and surfaces are worked out when they are asked for: what a body does not
use may be of a kind that is not known here.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from meshes.files.abaqus_deck import Keyword, Scope, Type, keywords_of
from meshes.files.content import ElementBlock, FileContent, Sets, known_rows
from meshes.files.elements import FACES

_OF_SET = ("NSET", "ELSET", "INSTANCE", "GENERATE", "INTERNAL", "UNSORTED", "INPUT")
_DEEPEST = 20
"""Sets that are members of one another."""


class Labels[Item](Mapping[str, Item]):
    """Items by names whose case is ignored; every spelling is listed."""

    def __init__(self, items: Iterable[tuple[str, Item]]) -> None:
        self._names: dict[str, None] = {}
        self._items: dict[str, Item] = {}
        for name, item in items:
            self._names[name] = None
            self._items.setdefault(name.upper(), item)

    def __getitem__(self, name: str) -> Item:
        return self._items[name.upper()]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


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

    name: str
    numbers: Ints
    first_node: int
    element_numbers: Ints
    first_element: int
    sets: Mapping[Type, Labels[list[Keyword | Ints]]]


def abaqus_content(file: Path) -> FileContent:
    """Nodes, elements, sets and surfaces of a deck.

    Sets and surfaces of parts have the name they have there, those of several instances together;
    and, behind the name of the instance and a dot, those of each. All elements of an instance are a
    set by its name.
    """
    flat, parts, instances = _scopes(file)
    if not instances:
        instances = [_Instance(name, name) for name in parts]
    blocks: list[ElementBlock] = []
    points: list[Floats] = []
    numbers: list[Ints] = []
    places: dict[str, _Place] = {}
    for instance in [_Instance("", ""), *instances]:
        scope = flat
        if instance.name:
            known = ", ".join(parts) or "none"
            told = f"*INSTANCE, PART={instance.part}"
            require(instance.part in parts, "file", told, f"one of {known}")
            scope = parts[instance.part].and_also(instance.own)
        own, positions = scope.numbered()
        first_node, first_element = sum(map(len, points)), sum(map(len, blocks))
        new = list(scope.blocks(own, first_node))
        elements = np.concatenate([np.empty(0, dtype=np.int64), *(b.numbers for b in new)])
        places[instance.name.upper()] = _Place(
            instance.name, own, first_node, elements, first_element, _by_label(scope.sets)
        )
        points.append(_placed(positions, instance))
        numbers.append(own)
        blocks += new
    require(sum(map(len, points)) > 0, "file", "no nodes", "a deck with *NODE and *ELEMENT")
    left_out = [each for scope in (flat, *parts.values()) for each in scope.told]
    content = FileContent(np.concatenate(points), np.concatenate(numbers), blocks, told=left_out)
    return _Resolver(content, places).with_sets()


def _scopes(file: Path) -> tuple[Scope, dict[str, Scope], list[_Instance]]:
    """What stands outside of parts, each part, and the instances of parts."""
    flat, parts, instances = Scope(), dict[str, Scope](), list[_Instance]()
    inside = flat
    for keyword in keywords_of(file):
        match keyword.name:
            case "PART":
                keyword.check("NAME", "INTERNAL")
                inside = parts.setdefault(keyword.needed("NAME").upper(), Scope())
            case "INSTANCE":
                keyword.check("NAME", "PART", "NSET", "ELSET", "INTERNAL")
                name, part = keyword.needed("NAME"), keyword.needed("PART")
                instances.append(_Instance(name, part.upper(), keyword.lines))
                inside = instances[-1].own
                for kind in ("NSET", "ELSET"):  # all that the instance has
                    if kind in keyword.parameters:
                        whole = keyword.needed(kind)
                        flat.take(Keyword(kind, {str(kind): whole}, name.encode()))
            case "END PART" | "END INSTANCE" | "ASSEMBLY" | "END ASSEMBLY":
                inside = flat
            case "STEP":
                break  # from here on it says what is done
            case _:
                inside.take(keyword)
    return flat, parts, instances


def _by_label(
    sets: Mapping[Type, list[tuple[str, Keyword | Ints]]],
) -> dict[Type, Labels[list[Keyword | Ints]]]:
    """What lists the members of each set, keyword by keyword; of a surface, the last alone."""
    found: dict[Type, Labels[list[Keyword | Ints]]] = {}
    for kind, given in sets.items():
        found[kind] = Labels((name, []) for name, _ in given)
        for name, members in given:
            listed = found[kind][name]
            if kind == "surface":
                listed.clear()
            listed.append(members)
    return found


def _placed(points: Floats, instance: _Instance) -> Floats:
    """Points of a part where its instance stands: shifted, then turned about an axis."""
    try:
        lines = [[float(each) for each in line if each] for line in instance.placing]
    except ValueError:
        lines = [[]]
    allowed = "a line of a translation, and one of two points of an axis and an angle"
    sizes = [len(line) for line in lines]
    told = f"*INSTANCE, NAME={instance.name}"
    require(sizes in ([], [3], [3, 7]), "file", told, allowed)
    if sizes:
        points = points + lines[0]
    if len(sizes) > 1:
        start, end, angle = np.array(lines[1][:3]), np.array(lines[1][3:6]), lines[1][6]
        axis = end - start
        require(bool(np.any(axis)), "file", told, allowed)
        turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis), degrees=True)
        points = start + turn.apply(points - start)
    return points


class _Resolver:
    """Finds what sets and surfaces of a deck have as members."""

    def __init__(self, content: FileContent, places: Mapping[str, _Place]) -> None:
        self.content, self.places = content, places
        self._open: list[tuple[Type, str, str]] = []
        self._made: dict[tuple[Type, str, str], Ints] = {}

    def with_sets(self) -> FileContent:
        """The content with its sets, after a look at the names in them."""
        for key, place in self.places.items():
            for kind in ("node", "element"):
                for name in place.sets[kind]:
                    self._check_names(kind, key, place.sets[kind][name])
        return replace(
            self.content,
            node_sets=self._sets("node"),
            element_sets=self._sets("element"),
            face_sets=self._sets("surface"),
        )

    def _sets(self, kind: Type) -> Sets:
        """Sets of a type by name: those of all instances together, and those of each."""
        together: list[tuple[str, list[str]]] = []
        for key, place in self.places.items():
            for name in place.sets[kind]:
                together.append((name, [k for k, p in self.places.items() if name in p.sets[kind]]))
                if key:
                    together.append((f"{place.name}.{name}", [""]))
        if kind == "element":
            together += [(place.name, [""]) for key, place in self.places.items() if key]
        labels = Labels((name, (name, keys)) for name, keys in together)
        return Sets(
            labels, lambda item: self._joined(self.members(kind, key, item[0]) for key in item[1])
        )

    @staticmethod
    def _joined(parts: Iterable[Ints]) -> Ints:
        return np.unique(np.concatenate([*parts]), axis=0)

    def members(self, kind: Type, key: str, name: str) -> Ints:
        """Rows of nodes, elements, or faces (n, 2) of a set, of an instance or with its name."""
        place = self.places[key]
        instance, dot, inner = name.partition(".")
        if name not in place.sets[kind]:
            if dot and instance.upper() in self.places:
                return self._entry(kind, instance.upper(), inner)
            whole = self.places.get(name.upper()) if name else None
            if kind == "surface" or whole is None:
                raise InputError("file", name, f"a set of {kind}s that the deck has")
            return self._rows(
                kind, whole, whole.numbers if kind == "node" else whole.element_numbers
            )
        mark = kind, key, name.upper()
        if mark not in self._made:
            allowed = f"sets that are not inside each other, and at most {_DEEPEST} deep"
            require(mark not in self._open and len(self._open) < _DEEPEST, "file", name, allowed)
            self._open.append(mark)
            try:
                self._made[mark] = self._joined(
                    [
                        np.empty((0, 2) if kind == "surface" else 0, dtype=np.int64),
                        *(self._of_listed(kind, key, each) for each in place.sets[kind][name]),
                    ]
                )
            finally:
                self._open.pop()
        return self._made[mark]

    def _of_listed(self, kind: Type, key: str, listed: Keyword | Ints) -> Ints:
        """Rows, or faces, of what a set is made of."""
        if not isinstance(listed, Keyword):
            return self._rows(kind, self.places[key], listed)
        return self._faces(key, listed) if kind == "surface" else self._listed(kind, key, listed)

    def _listed(self, kind: Type, key: str, keyword: Keyword) -> Ints:
        """Rows that a keyword lists."""
        keyword.check(*_OF_SET)
        inside = self._inside(key, keyword)
        if kind == "node" and "ELSET" in keyword.parameters:
            return self._nodes_of(self.members("element", inside, keyword.parameters["ELSET"]))
        numbers, names = keyword.members()
        own = self._rows(kind, self.places[inside], numbers)
        return self._joined([own, *(self._entry(kind, inside, name) for name in names)])

    def _inside(self, key: str, keyword: Keyword) -> str:
        instance = keyword.parameters.get("INSTANCE", key).upper()
        require(instance in self.places, "file", instance, "an instance that the deck has")
        return instance

    def _check_names(self, kind: Type, key: str, listed: Iterable[Keyword | Ints]) -> None:
        """Refuse sets that are made of ones that are not there."""
        for each in listed:
            if isinstance(each, Keyword) and re.search(rb"[A-Za-z_]", each.data):
                sets = self.places[self._inside(key, each)].sets[kind]
                for name in each.members()[1]:
                    instance = name.partition(".")[0].upper()
                    if name not in sets and instance not in self.places:
                        raise InputError("file", name, f"a set of {kind}s that the deck has")

    def _entry(self, kind: Type, key: str, text: str) -> Ints:
        """Rows of a number or of a set."""
        if text.isascii() and text.isdecimal() and len(text) < 16 and kind != "surface":
            return self._rows(kind, self.places[key], np.array([int(text)], dtype=np.int64))
        return self.members(kind, key, text)

    @staticmethod
    def _rows(kind: Type, place: _Place, numbers: Ints) -> Ints:
        if kind == "node":
            return place.first_node + known_rows(place.numbers, numbers)
        return place.first_element + known_rows(place.element_numbers, numbers)

    def _nodes_of(self, elements: Ints) -> Ints:
        found = [b.nodes[rows].ravel() for b, rows in self._by_block(elements)]
        return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *found]))

    def _by_block(self, elements: Ints) -> Iterator[tuple[ElementBlock, Ints]]:
        """Elements of each kind among given ones, as rows of its block."""
        for each, start in zip(self.content.blocks, self.content.starts, strict=False):
            yield each, elements[(elements >= start) & (elements < start + len(each))] - start

    def _faces(self, key: str, keyword: Keyword) -> Ints:
        """Elements and their faces that a surface has, -1 for all free ones, (n, 2)."""
        keyword.check("NAME", "TYPE", "COMBINE", "INTERNAL")
        if "COMBINE" in keyword.parameters:
            return self._combined(key, keyword)
        found = [np.empty((0, 2), dtype=np.int64)]
        for line in keyword.lines:
            elements, label = self._entry("element", key, line[0]), "".join(line[1:2]).upper()
            side = int(label[1:]) - 1 if re.fullmatch("S[1-9]", label) else -1
            for each, rows in self._by_block(elements):
                count = len(FACES.get(each.cell, ()))
                fits = not label or 0 <= side < count or not len(rows)
                require(fits, "file", label, f"faces S1 to S{count} of {each.kind}")
            found.append(np.stack([elements, np.full(len(elements), side)], axis=1))
        return np.concatenate(found)

    def _combined(self, key: str, keyword: Keyword) -> Ints:
        """Faces of surfaces that others are made of."""
        how = keyword.parameters["COMBINE"].upper()
        first, *rest = [
            self.members("surface", key, n) for line in keyword.lines for n in line if n
        ]
        if how == "UNION":
            return np.concatenate([first, *rest])
        told = f"*SURFACE, COMBINE={how}"
        fits = how in ("INTERSECTION", "DIFFERENCE") and len(rest) == 1
        named = all((faces[:, 1] >= 0).all() for faces in (first, *rest))
        allowed = "UNION, or INTERSECTION or DIFFERENCE of two surfaces of numbered faces"
        require(fits and named, "file", told, allowed)
        shared = np.isin(first @ [8, 1], rest[0] @ [8, 1])
        return first[shared if how == "INTERSECTION" else ~shared]
