"""What a deck holds in one part, or outside of parts: nodes, elements, what lists its sets."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from cea.errors import InputError, require
from meshes.files.abaqus_deck import Keyword
from meshes.files.content import ElementBlock, Floats, Ints, Role, rows_of
from meshes.files.kinds import KINDS, block

Type = Literal["node", "element", "surface"]

_SOLID = re.compile(r"C3D(4|5|6|8|10|13|15|20)(?!V)[A-Z]*")
_PLANE = re.compile(r"(CPE|CPS|SFM3D)(3|4|6|8)[A-Z]*")
_SHELL = re.compile(r"(S|STRI|DS|M3D|R3D)(3|4|6|8)[A-Z0-9]*")
_OTHER_SOLIDS = ("C3D15V", "C3D27")
"""Wedges and hexahedra that may have nodes in the middles of some faces, not of others."""
_OF_SOLID = {4: "tetrahedron", 10: "tetrahedron", 5: "pyramid", 13: "pyramid"}
_OF_SOLID |= {6: "wedge", 15: "wedge", 8: "hexahedron", 20: "hexahedron"}
_OF_PLANE = {3: "triangle", 6: "triangle", 4: "quadrilateral", 8: "quadrilateral"}
_NOT_READ = (
    *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"),
    *("PARAMETER", "IMPORT", "IMPERFECTION"),
)
"""Keywords that make, move or bring along nodes and elements."""


@dataclass
class Scope:
    """What a part holds, or a deck outside of parts.

    Parameters
    ----------
    nodes
        Numbers and positions of nodes, keyword by keyword.
    elements
        Elements, keyword by keyword; their nodes as numbers, not rows.
    sets
        Name, and numbers or what lists them, of sets of each type and of surfaces.
    told
        What was not taken from the deck.
    """

    nodes: list[tuple[Ints, Floats]] = field(default_factory=list)
    elements: list[ElementBlock] = field(default_factory=list)
    sets: dict[Type, list[tuple[str, Keyword | Ints]]] = field(
        default_factory=lambda: {"node": [], "element": [], "surface": []}
    )
    told: list[str] = field(default_factory=list)

    def take(self, keyword: Keyword) -> None:
        """Take in what a keyword holds; keywords that say nothing of the mesh are passed over."""
        match keyword.name:
            case "NODE":
                keyword.check("NSET", "SYSTEM", "INPUT")
                system = keyword.parameters.get("SYSTEM", "R").upper()
                require(system == "R", "file", f"*NODE, SYSTEM={system}", "cartesian coordinates")
                self.nodes.append(keyword.nodes())
                if name := keyword.parameters.get("NSET"):
                    self.sets["node"].append((name, self.nodes[-1][0]))
            case "ELEMENT":
                keyword.check("TYPE", "ELSET", "INPUT")
                self.elements.append(self._elements(keyword))
                if name := keyword.parameters.get("ELSET"):
                    self.sets["element"].append((name, self.elements[-1].numbers))
            case "NSET":
                self.sets["node"].append((keyword.needed("NSET"), keyword))
            case "ELSET":
                self.sets["element"].append((keyword.needed("ELSET"), keyword))
            case "SURFACE":
                self._take_surface(keyword)
            case name if name in _NOT_READ:
                allowed = "a deck that lists nodes and elements: write it out without this keyword"
                raise InputError("file", f"*{name}", allowed)

    def and_also(self, other: "Scope") -> "Scope":
        """What both hold."""
        sets = {each: self.sets[each] + other.sets[each] for each in self.sets}
        return Scope(self.nodes + other.nodes, self.elements + other.elements, sets)

    def numbered(self) -> tuple[Ints, Floats]:
        """Numbers and positions of all nodes; the last of those given again."""
        if not self.nodes:
            return np.empty(0, dtype=np.int64), np.empty((0, 3))
        numbers, points = (np.concatenate(parts) for parts in zip(*self.nodes, strict=True))
        last, place = np.unique(numbers[::-1], return_index=True)
        return last, points[::-1][place]

    def blocks(self, numbers: Ints, first: int) -> Iterator[ElementBlock]:
        """Elements whose nodes are rows, counted from the first, of the nodes of given numbers."""
        for each in self.elements:
            rows = np.full(each.nodes.shape, -1, dtype=np.int64)
            there = each.nodes >= 0
            rows[there] = first + rows_of(numbers, each.nodes[there], "a node")
            yield replace(each, nodes=rows)

    def _elements(self, keyword: Keyword) -> ElementBlock:
        kind = keyword.needed("TYPE").upper()
        role, known = _known(kind)
        if not known:
            numbers = keyword.element_numbers()
            none = np.empty((len(numbers), 0), dtype=np.int64)
            return ElementBlock(kind, "other", 1, numbers, none, role)
        rows, longer = keyword.elements(len(KINDS[known].groups))
        if longer:
            self.told.append(f"numbers behind the nodes of {longer} elements {kind}")
        return block(kind, known, rows[:, 0], rows[:, 1:], role=role)

    def _take_surface(self, keyword: Keyword) -> None:
        name, of = keyword.needed("NAME"), keyword.parameters.get("TYPE", "ELEMENT").upper()
        if of == "NODE":
            parameters = {
                key: v for key, v in keyword.parameters.items() if key not in ("TYPE", "NAME")
            }
            firsts = "\n".join(line[0] for line in keyword.lines).encode()  # areas follow
            self.sets["node"].append((name, Keyword("SURFACE", parameters, firsts)))
        elif of == "ELEMENT":
            self.sets["surface"].append((name, keyword))


def _known(kind: str) -> tuple[Role, str]:
    """Role of a type of element, and its name in the table of kinds; none where it is not there."""
    if match := _SOLID.fullmatch(kind):
        nodes = int(match[1])
        return "solid", f"{_OF_SOLID[nodes]}{nodes}"
    for plane in (_PLANE, _SHELL):
        if match := plane.fullmatch(kind):
            nodes = int(match[2])
            role: Role = "mark" if plane is _PLANE else "structural"
            return "solid" if match[1] == "CPE" else role, f"{_OF_PLANE[nodes]}{nodes}"
    return "solid" if kind.startswith(_OTHER_SOLIDS) else "structural", ""
