"""What a deck holds in one part, or outside of parts."""

import re
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from cea.errors import InputError, require
from meshes.files.abaqus.deck import Floats, Ints, Keyword
from meshes.files.content import ElementBlock, Role, rows_of
from meshes.files.kinds import KINDS, block

_SOLID = re.compile(r"C3D(4|5|6|8|10|13|15|20)(?!V)[A-Z]*")
_PLANE = re.compile(r"(CPE|CPS|SFM3D)(3|4|6|8)[A-Z]*")
_SHELL = re.compile(r"(S|STRI|DS|M3D|R3D)(3|4|6|8)[A-Z0-9]*")
_NODES_OF_SOLID = {4: "tetrahedron", 5: "pyramid", 6: "wedge", 8: "hexahedron"}
_NODES_OF_SOLID |= {10: "tetrahedron", 13: "pyramid", 15: "wedge", 20: "hexahedron"}
_NODES_OF_PLANE = {3: "triangle", 6: "triangle", 4: "quadrilateral", 8: "quadrilateral"}
_OTHER_SOLIDS = ("C3D15V", "C3D27")
"""Wedges and hexahedra that may have nodes in the middles of some faces, not of others."""
_GENERATED = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM")
"""Keywords that make or move nodes and elements, which are not read."""

_LONGEST = 10**8
"""Members of a set."""


class Members(NamedTuple):
    """Members of a set: numbers, and names of other sets."""

    instance: str
    numbers: Ints
    names: tuple[str, ...]


@dataclass
class Scope:
    """Nodes, elements, sets and surfaces of a part; names of sets in capitals where they are used.

    Parameters
    ----------
    nodes
        Numbers and positions of nodes, keyword by keyword.
    elements
        Elements, keyword by keyword; their nodes as numbers, not rows.
    node_sets, element_sets
        Members of each set.
    surfaces
        Type and entries of each surface.
    """

    nodes: list[tuple[Ints, Floats]] = field(default_factory=list)
    elements: list[ElementBlock] = field(default_factory=list)
    node_sets: dict[str, list[Members]] = field(default_factory=dict)
    element_sets: dict[str, list[Members]] = field(default_factory=dict)
    surfaces: dict[str, tuple[str, list[list[str]]]] = field(default_factory=dict)

    def take(self, keyword: Keyword) -> None:
        """Take in what a keyword holds; keywords that say nothing of the mesh are passed over.

        Raises
        ------
        InputError
            When it is not as the format has it, or generates nodes or elements.
        """
        match keyword.name:
            case "NODE":
                self._take_nodes(keyword)
            case "ELEMENT":
                self._take_elements(keyword)
            case "NSET":
                self._take_set(self.node_sets, keyword, keyword.needed("NSET"))
            case "ELSET":
                self._take_set(self.element_sets, keyword, keyword.needed("ELSET"))
            case "SURFACE":
                kind = keyword.parameters.get("TYPE", "ELEMENT").upper()
                self.surfaces[keyword.needed("NAME")] = kind, keyword.lines
            case name if name in _GENERATED:
                allowed = "a deck that lists nodes and elements: write it out without this keyword"
                raise InputError("file", f"*{name}", allowed)

    def numbered(self) -> tuple[Ints, Floats]:
        """Numbers and positions of all nodes; the last of those given again."""
        if not self.nodes:
            return np.empty(0, dtype=np.int64), np.empty((0, 3))
        numbers, points = (np.concatenate(parts) for parts in zip(*self.nodes, strict=True))
        last, place = np.unique(numbers[::-1], return_index=True)
        return last, points[::-1][place]

    def blocks(self, numbers: Ints) -> list[ElementBlock]:
        """Elements whose nodes are rows of the nodes of given numbers."""
        found = []
        for each in self.elements:
            rows = np.full(each.nodes.shape, -1, dtype=np.int64)
            there = each.nodes >= 0
            rows[there] = rows_of(numbers, each.nodes[there], "a node")
            found.append(
                ElementBlock(each.kind, each.cell, each.order, each.numbers, rows, each.role)
            )
        return found

    def _take_nodes(self, keyword: Keyword) -> None:
        system = keyword.parameters.get("SYSTEM", "R").upper()
        require(system == "R", "file", f"*NODE, SYSTEM={system}", "cartesian coordinates")
        values = keyword.numbers()
        lines = len([line for line in keyword.data.split(b"\n") if line.strip()])
        columns, rest = divmod(len(values), max(lines, 1))
        fits = lines == 0 or (rest == 0 and columns in (3, 4, 7))
        require(fits, "file", f"*NODE of {lines} lines", "a number and coordinates in each")
        rows = values.reshape(lines, columns) if lines else np.empty((0, 4))
        numbers = _whole(rows[:, 0], "*NODE")
        points = np.zeros((lines, 3))
        points[:, : min(columns - 1, 3) if lines else 3] = rows[:, 1:4]
        self.nodes.append((numbers, points))
        if name := keyword.parameters.get("NSET"):
            self.node_sets.setdefault(name, []).append(Members("", numbers, ()))

    def _take_elements(self, keyword: Keyword) -> None:
        kind, role, known = _known(keyword.needed("TYPE").upper())
        values = keyword.whole_numbers() if known else np.empty(0, dtype=np.int64)
        if known:
            per_element = len(KINDS[known].reference) + 1
            fits = len(values) % per_element == 0
            value = f"*ELEMENT, TYPE={kind} with {len(values)} numbers"
            require(fits, "file", value, f"{per_element} for each element")
            rows = values.reshape(-1, per_element)
            self.elements.append(block(kind, known, rows[:, 0], rows[:, 1:], role=role))
        else:
            there = np.zeros(1, dtype=np.int64)  # one stands for them all
            none = np.empty((1, 0), dtype=np.int64)
            self.elements.append(ElementBlock(kind, "other", 1, there, none, role))
        if name := keyword.parameters.get("ELSET"):
            numbers = self.elements[-1].numbers
            self.element_sets.setdefault(name, []).append(Members("", numbers, ()))

    @staticmethod
    def _take_set(sets: dict[str, list[Members]], keyword: Keyword, name: str) -> None:
        fields = [each for line in keyword.lines for each in line if each]
        names = tuple(each for each in fields if not each.lstrip("+-").isdecimal())
        if "GENERATE" in keyword.parameters:
            numbers = _generated(keyword)
            names = ()
        else:
            inside = [each for each in fields if each not in set(names)]
            values = np.array(inside, dtype="S32").astype(float)
            numbers = _whole(values, f"*{keyword.name}")
        instance = keyword.parameters.get("INSTANCE", "")
        sets.setdefault(name, []).append(Members(instance, numbers, names))


def _known(kind: str) -> tuple[str, Role, str]:
    """Kind, role and name in the table of kinds of a type of element; no name where not there."""
    if match := _SOLID.fullmatch(kind):
        nodes = int(match[1])
        return kind, "solid", f"{_NODES_OF_SOLID[nodes]}{nodes}"
    for plane in (_PLANE, _SHELL):
        if match := plane.fullmatch(kind):
            nodes = int(match[2])
            role: Role = "mark" if plane is _PLANE else "structural"
            role = "solid" if match[1] == "CPE" else role
            return kind, role, f"{_NODES_OF_PLANE[nodes]}{nodes}"
    return kind, "solid" if kind.startswith(_OTHER_SOLIDS) else "structural", ""


def _generated(keyword: Keyword) -> Ints:
    """Numbers that first, last and step stand for."""
    found = [np.empty(0, dtype=np.int64)]
    for line in keyword.lines:
        given = [each for each in line if each]
        step = 0
        if 2 <= len(given) <= 3 and all(each.isdecimal() and len(each) < 12 for each in given):
            first, last, step = [*map(int, given), 1][:3]
        fits = step > 0 and first <= last and (last - first) // step < _LONGEST
        require(fits, "file", f"*{keyword.name}, GENERATE: {line}", "first, last and step")
        found.append(np.arange(first, last + 1, step))
    return np.concatenate(found)


def _whole(values: Floats, place: str) -> Ints:
    whole = bool((values == np.rint(values)).all() and (np.abs(values) < 2**53).all())
    require(whole, "file", place, "whole numbers of nodes and elements")
    return values.astype(np.int64)
