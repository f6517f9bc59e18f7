"""Content of a deck of Abaqus or CalculiX: parts and their instances, sets and surfaces.

Labels ignore case. Sets and surfaces are resolved only when a body uses them: others may be of
unsupported kinds.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from meshes.files.abaqus_deck import Keyword, is_number, keywords_of
from meshes.files.content import (
    ElementBlock,
    FileContent,
    Role,
    Sets,
    block,
    known_rows,
    rows_of,
    without_nodes,
)
from meshes.files.elements import KINDS

Type = Literal["node", "element", "surface"]

_TYPES: tuple[tuple[str, int, Role], ...] = (
    (r"C3D(4|5|6|8|10|13|15|20)(?!V)[A-Z]*", 3, "solid"),
    (r"CPE(3|4|6|8)[A-Z]*", 2, "solid"),
    (r"(?:CPS|SFM3D)(3|4|6|8)[A-Z]*", 2, "mark"),
    (r"(?:S|STRI|DS|M3D|R3D)(3|4|6|8)[A-Z0-9]*", 2, "structural"),
)
"""Types of elements with their number of nodes, their dimension and role."""
_OTHER_SOLIDS = ("C3D15V", "C3D27")
"""Wedges and hexahedra that may have nodes in the middles of some faces, not of others."""
_NAMES = {(kind.reference.shape[1], len(kind.groups)): name for name, kind in KINDS.items()}
"""Names in the table of kinds by dimension and number of nodes."""
_NOT_READ = re.compile(
    "NGEN|NFILL|NCOPY|NMAP|ELGEN|ELCOPY|SYSTEM|PARAMETER|IMPORT|IMPERFECTION|ADJUST|"
    "SYMMETRIC MODEL GENERATION"
)
"""Keywords that generate, move or import nodes and elements: they are refused."""
_CHANGES_BODY = re.compile(
    "(KINEMATIC |DISTRIBUTING |SHELL TO SOLID )?COUPLING|EQUATION|MPC|RIGID BODY|TIE|"
    "CYCLIC SYMMETRY MODEL|EMBEDDED ELEMENT|(ASSEMBLED )?FASTENER|FOUNDATION|MATRIX ASSEMBLE|"
    "NONSTRUCTURAL MASS|REBAR"
)
"""Keywords that add mass, stiffness or constraints. Each is an element that forms no body, also in
the set of elements that it names: a part without it may be chosen."""
_OF_SET = ("NSET", "ELSET", "INSTANCE", "GENERATE", "INTERNAL", "UNSORTED", "INPUT")


@dataclass(eq=False)
class Scope:
    """Content of a part, of an instance, or of a deck outside of both.

    ``sets`` are the keywords that list members, in their order; ``first_node`` and
    ``first_element`` are the first rows of an instance in the content.
    """

    name: str = ""
    placing: list[list[str]] = field(default_factory=list)
    nodes: list[tuple[Ints, Floats]] = field(default_factory=list)
    elements: list[ElementBlock] = field(default_factory=list)
    sets: list[tuple[Type, str, Keyword | Ints]] = field(default_factory=list)
    numbers: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    first_node: int = 0
    first_element: int = 0

    def placed(self, name: str, placing: list[list[str]]) -> "Scope":
        """An instance with the content of the part, to which its own is added."""
        return Scope(name, placing, [*self.nodes], [*self.elements], [*self.sets])

    def take(self, keyword: Keyword) -> None:
        """Add the content of a keyword; ignore keywords that do not concern the mesh."""
        match keyword.name:
            case "NODE":
                keyword.check("NSET", "SYSTEM", "INPUT")
                system = keyword.parameters.get("SYSTEM", "R").upper()
                require(system == "R", "file", f"*NODE, SYSTEM={system}", "cartesian coordinates")
                self.nodes.append(keyword.nodes())
                if name := keyword.parameters.get("NSET"):
                    self.sets.append(("node", name, self.nodes[-1][0]))
            case "ELEMENT":
                keyword.check("TYPE", "ELSET", "INPUT")
                self.elements.append(self._elements(keyword))
                if name := keyword.parameters.get("ELSET"):
                    self.sets.append(("element", name, self.elements[-1].numbers))
            case "NSET":
                self.sets.append(("node", keyword.needed("NSET"), keyword))
            case "ELSET":
                self.sets.append(("element", keyword.needed("ELSET"), keyword))
            case "SURFACE":
                self._take_surface(keyword)
            case name if _NOT_READ.fullmatch(name):
                allowed = "a deck that lists nodes and elements: write it out without this keyword"
                raise InputError("file", f"*{name}", allowed)
            case name if _CHANGES_BODY.fullmatch(name):
                number = np.array([-1 - len(self.elements)])  # of no other element
                self.elements.append(without_nodes(f"*{name}", number, "keyword"))
                elements = keyword.parameters.get("ELSET", "")
                if self.of("element", elements):
                    self.sets.append(("element", elements, number))

    def _elements(self, keyword: Keyword) -> ElementBlock:
        kind = keyword.needed("TYPE").upper()
        for pattern, dim, role in _TYPES:
            if match := re.fullmatch(pattern, kind):
                known = _NAMES[dim, int(match[1])]
                rows = keyword.elements(len(KINDS[known].groups))
                return block(kind, known, rows[:, 0], rows[:, 1:], role=role)
        solid = kind.startswith(_OTHER_SOLIDS)
        return without_nodes(kind, keyword.first_numbers(), "solid" if solid else "structural")

    def _take_surface(self, keyword: Keyword) -> None:
        name, of = keyword.needed("NAME"), keyword.parameters.get("TYPE", "ELEMENT").upper()
        if of == "NODE":
            own = {key: v for key, v in keyword.parameters.items() if key not in ("TYPE", "NAME")}
            firsts = "\n".join(line[0] for line in keyword.lines)  # areas follow
            self.sets.append(("node", name, Keyword("SURFACE", own, firsts)))
        elif of == "ELEMENT":
            self.sets.append(("surface", name, keyword))

    def place(self, first_node: int, first_element: int) -> Floats:
        """Number nodes and elements from given first rows; return positions of nodes, (n, 3)."""
        self.first_node, self.first_element = first_node, first_element
        points = np.empty((0, 3))
        if self.nodes:  # the last one if a node is given again
            every, at = (np.concatenate(parts) for parts in zip(*self.nodes, strict=True))
            self.numbers, last = np.unique(every[::-1], return_index=True)
            points = at[::-1][last]
        self.elements = [
            replace(each, nodes=first_node + rows_of(self.numbers, each.nodes, "a node"))
            for each in self.elements
        ]
        return self._moved(points)

    def _moved(self, points: Floats) -> Floats:
        """Points of an instance: those of its part translated, then rotated about an axis."""
        try:
            lines = [np.array([float(each) for each in line if each]) for line in self.placing]
        except ValueError:
            lines = [np.empty(0)]
        told = f"*INSTANCE, NAME={self.name}"
        allowed = "a line of a translation, and one of two points of an axis and an angle"
        require([*map(len, lines)] in ([], [3], [3, 7]), "file", told, allowed)
        if lines:
            points = points + lines[0]
        if len(lines) > 1:
            start, axis = lines[1][:3], lines[1][3:6] - lines[1][:3]
            require(bool(np.any(axis)), "file", told, allowed)
            vector = lines[1][6] * axis / np.linalg.norm(axis)
            points = start + Rotation.from_rotvec(vector, degrees=True).apply(points - start)
        return points

    def of(self, kind: Type, name: str) -> list[Keyword | Ints]:
        """Keywords that list the members of a set, in order; of a surface only the last."""
        listed = [m for of, own, m in self.sets if of == kind and own.upper() == name.upper()]
        return listed[-1:] if kind == "surface" else listed

    def rows(self, kind: Type, numbers: Ints | None = None) -> Ints:
        """Rows in the content of nodes or elements of given numbers, or of all."""
        first, own = self.first_node, self.numbers
        if kind == "element":
            first, own = self.first_element, _joined(b.numbers for b in self.elements)
        return first + known_rows(own, own if numbers is None else numbers)


def abaqus_content(file: Path) -> FileContent:
    """Read nodes, elements, sets and surfaces of a deck.

    Sets and surfaces of parts keep their names, joined over all instances; those of one instance
    follow its name and a dot. All elements of an instance are a set with its name.
    """
    every = _scopes(file)
    points: list[Floats] = []
    count = 0
    for scope in every:
        points.append(scope.place(sum(map(len, points)), count))
        count += sum(map(len, scope.elements))
    require(sum(map(len, points)) > 0, "file", "no nodes", "a deck with *NODE and *ELEMENT")
    content = FileContent(
        np.concatenate(points),
        np.concatenate([scope.numbers for scope in every]),
        [each for scope in every for each in scope.elements],
    )
    return _Resolver(content, {scope.name.upper(): scope for scope in every}).with_sets()


def _scopes(file: Path) -> list[Scope]:
    """Content outside of parts, then the instances of parts, or the parts if there are none."""
    flat, parts, instances = Scope(), dict[str, Scope](), list[Scope]()
    inside = flat
    for keyword in keywords_of(file):
        match keyword.name:
            case "PART":
                keyword.check("NAME", "INTERNAL")
                name = keyword.needed("NAME")
                inside = parts.setdefault(name.upper(), Scope(name))
            case "INSTANCE":
                keyword.check("NAME", "PART", "NSET", "ELSET", "INTERNAL")
                name, part = keyword.needed("NAME"), keyword.needed("PART")
                told, known = f"*INSTANCE, PART={part}", ", ".join(parts) or "none"
                require(part.upper() in parts, "file", told, f"one of {known}")
                inside = parts[part.upper()].placed(name, keyword.lines)
                instances.append(inside)
                for kind in ("NSET", "ELSET"):  # all that the instance has
                    if kind in keyword.parameters:
                        flat.take(Keyword(kind, {str(kind): keyword.needed(kind)}, name))
            case "END PART" | "END INSTANCE" | "ASSEMBLY" | "END ASSEMBLY":
                inside = flat
            case "STEP":
                break  # no mesh follows
            case _:
                inside.take(keyword)
    return [flat, *(instances or parts.values())]


def _joined(parts: Iterable[Ints]) -> Ints:
    return np.concatenate([np.empty(0, dtype=np.int64), *parts])


class _Resolver:
    """Finds the members of sets and surfaces of a deck.

    A set is identified by its kind, the scope in which it is looked up, and its name there.
    """

    def __init__(self, content: FileContent, scopes: dict[str, Scope]) -> None:
        self.content, self.scopes = content, scopes
        self.members = cache(self._members)

    def with_sets(self) -> FileContent:
        """Check the names in sets, and return the content with its sets."""
        for key, scope in self.scopes.items():
            for kind, _, listed in scope.sets:
                if kind == "surface" or not isinstance(listed, Keyword):
                    continue
                for name in listed.members()[1] if re.search("[A-Za-z_]", listed.data) else ():
                    self._place(kind, self._inside(key, listed), name)
        return replace(
            self.content,
            node_sets=self._sets("node"),
            element_sets=self._sets("element"),
            face_sets=self._sets("surface"),
        )

    def _sets(self, kind: Type) -> Sets:
        """Sets of a kind by name: those of all instances together, and those of each."""
        names = []
        for key, scope in self.scopes.items():
            own = [name for of, name, _ in scope.sets if of == kind]
            names += [*own, *(f"{scope.name}.{name}" for name in own if key)]
            if kind == "element" and key:
                names.append(scope.name)
        return Sets(names, lambda name: self._of_all(kind, name), any_case=True)

    def _of_all(self, kind: Type, name: str) -> Ints:
        """Members of the sets of a name in all instances, or of one inside an instance."""
        keys = [key for key, scope in self.scopes.items() if scope.of(kind, name)] or [""]
        try:
            parts = [self.members(kind, key, name) for key in keys]
        except RecursionError:
            raise InputError("file", name, "sets that are not inside each other") from None
        return np.unique(np.concatenate(parts), axis=0)

    def _place(self, kind: Type, key: str, name: str) -> tuple[str, str]:
        """Scope and name of a set that a scope has or names; "" for a whole instance."""
        if self.scopes[key].of(kind, name):
            return key, name
        instance, dot, inner = name.partition(".")
        known = bool(instance) and instance.upper() in self.scopes
        whole = bool(inner) if dot else kind != "surface"
        require(known and whole, "file", name, f"a set of {kind}s that the deck has")
        return instance.upper(), inner

    def _inside(self, key: str, keyword: Keyword) -> str:
        """Scope in which the members of a set are looked up."""
        instance = keyword.parameters.get("INSTANCE", key).upper()
        require(instance in self.scopes, "file", instance, "an instance that the deck has")
        return instance

    def _members(self, kind: Type, key: str, name: str) -> Ints:
        """Rows of nodes, elements, or faces (n, 2) of a set."""
        scope, inner = self._place(kind, key, name)
        if inner != name:
            if inner and not (is_number(inner) and kind != "surface"):
                return self.members(kind, scope, inner)
            numbers = np.array([int(inner[:16])]) if inner else None
            return self.scopes[scope].rows(kind, numbers)
        parts = [self._of_listed(kind, key, each) for each in self.scopes[key].of(kind, name)]
        return np.unique(np.concatenate(parts), axis=0)

    def _of_listed(self, kind: Type, key: str, listed: Keyword | Ints) -> Ints:
        """Rows, or faces, that a keyword lists."""
        if not isinstance(listed, Keyword):
            return self.scopes[key].rows(kind, listed)
        if kind == "surface":
            return self._faces(key, listed)
        listed.check(*_OF_SET)
        inside = self._inside(key, listed)
        if kind == "node" and "ELSET" in listed.parameters:
            elements = self.members("element", inside, listed.parameters["ELSET"])
            return _joined(b.nodes[rows].ravel() for b, rows in self.content.by_block(elements))
        return self._listed(kind, inside, listed)

    def _listed(self, kind: Type, key: str, keyword: Keyword) -> Ints:
        """Rows of nodes or elements that a keyword lists by numbers and by names of sets."""
        numbers, names = keyword.members()
        of_sets = (self.members(kind, key, name) for name in names)
        return _joined([self.scopes[key].rows(kind, numbers), *of_sets])

    def _faces(self, key: str, keyword: Keyword) -> Ints:
        """Elements and faces of a surface, -1 for all free faces, (n, 2)."""
        keyword.check("NAME", "TYPE", "COMBINE", "INTERNAL")
        how = keyword.parameters.get("COMBINE", "").upper()
        if not how:
            of_sides: dict[str, list[str]] = {"": []}
            for name, *side in keyword.lines:
                of_sides.setdefault("".join(side[:1]).upper(), []).append(name)
            listed = {
                label: self._listed("element", key, Keyword("SURFACE", {}, "\n".join(names)))
                for label, names in of_sides.items()
            }
            return np.concatenate([self.content.sided(e, label) for label, e in listed.items()])
        names = [name for line in keyword.lines for name in line if name]
        require(how == "UNION", "file", f"*SURFACE, COMBINE={how}", "UNION of surfaces")
        found = [self.members("surface", key, name) for name in names]
        return np.concatenate([np.empty((0, 2), dtype=np.int64), *found])
