"""Content of Nastran files: points in their coordinate systems, solid elements, marks of faces.

Fields of a card have 8 or 16 columns or stand between commas, in capitals or not; a tab ends a
field, ``$`` begins a comment. Lines whose first field is blank or begins with ``+`` or ``*``
continue a card. What the scene says itself (materials, supports, loads, the analysis) is passed
over. Any other card may change what the body is: it is reported as an element that was not read.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from meshes.files.content import ElementBlock, FileContent, Role, block, rows_of
from meshes.files.sandbox import checked_state

_NAME = re.compile(r"[A-Z][A-Z0-9]*")
_REAL = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[DE]?([+-]\d+)|[DE](\d+))?", re.ASCII)
"""The exponent may stand without a letter: 1.5-2 is 0.015."""
_INCLUDE = re.compile(r"(?mi)^[ \t]*INCLUDE[ \t]*(?:'([^']*)'|\"([^\"]*)\"|([^\s$]+)).*$")
_BEGIN = re.compile(r"(?mi)^[ \t]*BEGIN\b(?![^\n$]*(?:SUPER|MODULE)).*$")
_DEEPEST = 10
"""Files that include one another."""
_LARGEST = 2**33
"""Bytes of a file that is included."""
_NARROW, _WIDE = 8, 16
"""Columns of a field."""
_ENDS = {width: (*range(_NARROW, 80, width), 80) for width in (_NARROW, _WIDE)}
"""Columns at which fields end."""


class Card(NamedTuple):
    """A card: its name in capitals, and the fields after it, without blanks."""

    name: str
    fields: list[str]

    def text(self, place: int) -> str:
        """A field; empty where the card ends before."""
        return self.fields[place] if place < len(self.fields) else ""

    def whole(self, place: int, default: int | None = None) -> int:
        """A field as a whole number."""
        text = self.text(place)
        if not text and default is not None:
            return default
        try:
            number = int(text)
        except ValueError:
            number = 2**62
        self._require(abs(number) < 2**62, place, "a whole number")
        return number

    def real(self, place: int) -> float:
        """A field as a number; 0 where it is empty."""
        text = self.text(place)
        if not text:
            return 0.0
        match = _REAL.fullmatch(text.upper())
        value = float(f"{match[1]}E{match[2] or match[3] or 0}") if match else float("inf")
        self._require(abs(value) < float("inf"), place, "a number")
        return value

    def refuse(self, allowed: str) -> InputError:
        """What is wrong with it, told by its name and number."""
        return InputError("file", f"{self.name} {self.text(0)}".strip(), allowed)

    def _require(self, fits: bool, place: int, what: str) -> None:
        if not fits:
            told = f"{what} in field {place + 1} after its name, not '{self.text(place)}'"
            raise self.refuse(told)


def cards_of(file: Path) -> Iterator[Card]:
    """Cards of the bulk data of a file and of those that it includes, in their order."""
    text = _text(file, (), file.parent)
    begin = _BEGIN.search(text)
    card: Card | None = None
    mark = ""
    for line in text[begin.end() if begin else 0 :].splitlines():
        head, data, next_mark = _fields(line)
        if not (head or any(data)):
            continue
        if not head or head[0] in "+*":
            own = head.lstrip("+*")
            if card is None or (own and mark and own != mark):
                allowed = f"a line that continues the one before, which ends with '{mark}'"
                raise InputError("file", line.strip(), allowed)
            card.fields.extend([""] * (-len(card.fields) % len(data)) + data)
        else:
            if card is not None:
                yield card
            card = Card(head.rstrip("*_"), data)  # meshio writes CHEXA_
            allowed = "the name of a card at the beginning"
            require(bool(_NAME.fullmatch(card.name)), "file", line.strip(), allowed)
            if card.name == "ENDDATA":
                return
        mark = next_mark
    if card is not None:
        yield card


def _text(file: Path, outer: tuple[Path, ...], job: Path) -> str:
    """Text of a file with those that it includes in their places.

    Paths are counted from the folder of the file that includes, then from that of the first file.
    """
    circle = file in outer or len(outer) > _DEEPEST
    require(not circle, "file", str(file), f"files that include each other {_DEEPEST} deep at most")

    def included(match: re.Match[str]) -> str:
        # A long path goes on in the next line.
        parts = (match[1] or match[2] or match[3] or "").splitlines()
        path = "".join(part.strip() for part in parts).replace("\\", "/")
        places = [(folder / path).resolve() for folder in (file.parent, job)]
        found = next((place for place in places if place.is_file()), places[0])
        return _text(
            checked_state(found, "a file that is included", _LARGEST)[0], (*outer, file), job
        )

    return _INCLUDE.sub(included, file.read_text("utf-8", "replace"))


def _fields(line: str) -> tuple[str, list[str], str]:
    """First field in capitals, data, and the mark of a continuation of a line."""
    line = line.partition("$")[0].rstrip()
    if "," in line:
        head, *parts = (part.strip() for part in line.split(","))
        count = 4 if "*" in head else 8
        more = len(parts) > count + 1 or any(parts[count + 1 :])
        require(not more, "file", line, f"at most {count} fields in a line, and a mark")
        mark = "".join(parts[count:])
        data = (parts + [""] * count)[:count]
    else:
        head, data, mark = _columns(line)
    return head.upper(), data, mark.upper().lstrip("+*")


def _columns(line: str) -> tuple[str, list[str], str]:
    """The same of a line with fields of fixed width."""
    width = _WIDE if "*" in line[:_NARROW] else _NARROW
    if "\t" in line:
        line = _untabbed(line, width)
    if line[:1] == " " and line[:_NARROW].strip():
        # Either the name alone or the whole card may have moved to the right.
        ways = [way for way in (line, line.lstrip()) if _is_cut_between_fields(way, width)]
        fits = bool(ways) and _cut(ways[0], width) == _cut(ways[-1], width)
        require(fits, "file", line.strip(), "a card whose name begins in the first column")
        line = ways[0]
    head, *data, mark = _cut(line, width)
    return head, data, mark


def _cut(line: str, width: int) -> list[str]:
    return [line[a:b].strip() for a, b in pairwise((0, *_ENDS[width]))]


def _is_cut_between_fields(line: str, width: int) -> bool:
    """Whether the second field holds something, and no two fields touch."""
    cuts = _ENDS[width]
    apart = all(" " in (line[cut - 1 : cut], line[cut : cut + 1] or " ") for cut in cuts)
    return apart and bool(line[_NARROW : _NARROW + width].strip())


def _untabbed(line: str, width: int) -> str:
    """A line with blanks for its tabs: each ends a field, whether or not it fills its columns."""
    ends, filled = _ENDS[width], ""
    for part in line.split("\t"):
        filled += part
        if len(filled) not in ends or not part.strip():
            filled = filled.ljust(next((end for end in ends if end > len(filled)), 0))
    return filled


Cards = Mapping[str, Sequence[Card]]
"""Cards by their names."""


class _Kind(NamedTuple):
    """An element: its cell, corners and all nodes, and the order in which Nastran lists these."""

    cell: str
    corners: int
    nodes: int
    order: Sequence[int] = ()


_SOLIDS = {
    "CTETRA": _Kind("tetrahedron", 4, 10, range(10)),
    **dict.fromkeys(("CPYRAM", "CPYRA"), _Kind("pyramid", 5, 13, range(13))),
    "CPENTA": _Kind("wedge", 6, 15, (*range(9), 12, 13, 14, 9, 10, 11)),
    "CHEXA": _Kind("hexahedron", 8, 20, (*range(12), 16, 17, 18, 19, 12, 13, 14, 15)),
}
"""Middles of upright edges come before those of the top."""
_SHELLS = {
    **dict.fromkeys(("CTRIA3", "CTRIA6", "CTRIAR"), _Kind("triangle", 3, 3)),
    **dict.fromkeys(("CQUAD4", "CQUAD8", "CQUADR", "CQUAD"), _Kind("quadrilateral", 4, 4)),
}
"""Where they mark faces, corners are all that is needed of them."""
_PROPERTIES = {"PSOLID": 3, "PLSOLID": 3, "PCOMPS": 3, "PSHELL": 2, "PCOMP": 2, "PCOMPG": 2}
"""Dimension of the elements that have a property."""
_SYSTEMS = [f"CORD{way}{kind}" for way in "12" for kind in "RCS"]
_OF_THE_SCENE = re.compile(
    r"P\w+|MAT\w+|SPC\w*|SPOINT|EPOINT|SUPORT\d?|SET\d|SEQGP|SNORM|ECHO\w+|EIG\w+|FREQ\d?|TSTEP\w*"
    r"|FORCE\d?|MOMENT\d?|GRAV|ACCEL\d?|RFORCE\d?|[DRST]?LOAD\w*|LSEQ|DAREA|DELAY|DPHASE|DEFORM"
    r"|TEMP\w*|TIC|NLPARM|NLPCI|NLSTEP|TAB\w+|[ABCQ]SET\d?|USET\d?|OMIT\d?"
    r"|DESVAR|DRESP\d|DCON\w+|DV[A-Z]+\d|DOPTPRM|DLINK"
)
"""Properties, materials, supports, loads, analyses, sets for output, optimisation."""

_FLAT = 1e-9
"""Sine of an angle that is taken for zero."""


def nastran_content(file: Path) -> FileContent:
    """Nodes, elements and properties of a file; the latter are sets, as ``PSOLID 3``."""
    cards: dict[str, list[Card]] = defaultdict(list)
    for card in cards_of(file):
        cards[card.name].append(card)
    numbers, points = _Points(cards).positions()
    fluid = {card.whole(0) for card in cards["PSOLID"] if card.text(6).upper() == "PFLUID"}
    rows: dict[tuple[str, str, bool], list[tuple[int, int, list[int]]]] = defaultdict(list)
    for name, kind in (_SOLIDS | _SHELLS).items():
        for card in cards[name]:
            number, nodes = card.whole(0), _nodes(card, kind)
            of = card.whole(1, default=number)
            solid = name in _SOLIDS and of not in fluid
            rows[name, f"{kind.cell}{len(nodes)}", solid].append((number, of, nodes))
    require(bool(rows), "file", "no elements", f"some of {', '.join((*_SOLIDS, *_SHELLS))}")
    blocks: list[ElementBlock] = []
    of_elements: list[tuple[int, int]] = []
    for (name, kind_name, solid), elements in rows.items():
        ids, of_each, nodes_of = zip(*elements, strict=True)
        places = rows_of(numbers, np.array(nodes_of), "a point")
        role: Role = "solid" if solid else "structural"
        blocks.append(block(name, kind_name, np.array(ids), places, role=role))
        of_elements += [(3 if name in _SOLIDS else 2, of) for of in of_each]
    rows_of(np.concatenate([b.numbers for b in blocks]), np.empty(0, dtype=int), "an element")
    known = {*_SOLIDS, *_SHELLS, *_SYSTEMS, "GRID", "GRDSET"}
    others = {name for name, found in cards.items() if found} - known
    content = FileContent(points, numbers, blocks, _sets(cards, np.array(of_elements)))
    return content.with_others(sorted(n for n in others if not _OF_THE_SCENE.fullmatch(n)))


def _sets(cards: Cards, of_elements: Ints) -> dict[str, Ints]:
    """Elements of each property, from the dimension and the property of each, (n, 2)."""
    names = {
        (dim, card.whole(0)): name for name, dim in _PROPERTIES.items() for card in cards[name]
    }
    keys, group = np.unique(of_elements, axis=0, return_inverse=True)
    members = np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))[:-1])
    defaults = {3: "PSOLID", 2: "PSHELL"}
    return {
        f"{names.get((dim, number), defaults[dim])} {number}": rows
        for (dim, number), rows in zip(keys.tolist(), members, strict=True)
    }


def _nodes(card: Card, kind: _Kind) -> list[int]:
    """Nodes of an element in the order of :data:`meshes.files.elements.KINDS`; 0 is a blank."""
    corners = [card.whole(2 + i) for i in range(kind.corners)]
    more = range(kind.corners, kind.nodes) if any(card.fields[2 + kind.corners :]) else ()
    middles = [card.whole(2 + i, default=0) for i in more]
    if not any(middles):
        return corners
    if not all(middles) or any(card.fields[2 + kind.nodes :]):
        raise card.refuse(f"{kind.corners} or {kind.nodes} points, and nothing after them")
    listed = corners + middles
    return [listed[i] for i in kind.order]


class _System(NamedTuple):
    """A coordinate system: R cartesian, C cylindrical, S spherical; origin, axes in the columns."""

    kind: str
    origin: Floats
    axes: Floats

    def positions(self, given: Floats) -> Floats:
        """Positions in the basic system, (n, 3), of coordinates; angles are in degrees."""
        a, b, c = given[:, 0], np.radians(given[:, 1]), given[:, 2]
        local = given
        if self.kind == "C":
            local = np.stack([a * np.cos(b), a * np.sin(b), c], axis=1)
        if self.kind == "S":
            c = np.radians(c)
            local = np.stack([np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), np.cos(b)], axis=1)
            local *= a[:, None]
        return self.origin + local @ self.axes.T


class _Points:
    """Points of a file and the coordinate systems that they are given in."""

    def __init__(self, cards: Cards) -> None:
        self._grids = cards["GRID"]
        defaults = cards["GRDSET"]
        require(len(defaults) < 2, "file", "GRDSET", "one of these cards at most")
        self._default = defaults[0].whole(1, default=0) if defaults else 0
        self._found = {0: _System("R", np.zeros(3), np.eye(3))}
        self._given: dict[int, tuple[Card, int]] = {}
        for name in _SYSTEMS:
            for card in cards[name]:
                # CORD1 cards hold one or two systems.
                for start in (0, 4) if name[4] == "1" and card.text(4) else (0,):
                    number = card.whole(start)
                    fits = number > 0 and number not in self._given
                    require(fits, "file", f"{name} {number}", "a number of its own, from 1")
                    self._given[number] = card, start

    def positions(self) -> tuple[Ints, Floats]:
        """Number of each point, (n,), and its position in the basic system, (n, 3)."""
        numbers = np.array([card.whole(0) for card in self._grids], dtype=np.int64)
        require(len(numbers) > 0, "file", "no GRID", "a mesh")
        for card in self._grids:
            if any(card.fields[8:]):
                raise card.refuse("a point of eight fields at most")
        systems = np.array([self._of(card) for card in self._grids])
        points = np.array([_coordinates(card, 2) for card in self._grids])
        for number in np.unique(systems).tolist():
            own = systems == number
            points[own] = self._system(number, ()).positions(points[own])
        return numbers, points

    def _of(self, grid: Card) -> int:
        """Coordinate system of a point."""
        return grid.whole(1, default=self._default)

    def _system(self, number: int, outer: tuple[int, ...]) -> _System:
        """A coordinate system; ``outer`` are those that wait for it."""
        if number in self._found:
            return self._found[number]
        require(number in self._given, "file", f"CP {number}", "a coordinate system of the file")
        card, start = self._given[number]
        if number in outer:
            raise card.refuse("a coordinate system that is not defined by itself")
        outer = (*outer, number)
        if card.name[4] == "1":
            a, b, c = (self._position(card, start + i, outer) for i in (1, 2, 3))
        else:
            given = np.array([_coordinates(card, 2 + 3 * i) for i in range(3)])
            a, b, c = self._system(card.whole(1, default=0), outer).positions(given)
        self._found[number] = _System(card.name[5], a, _axes(card, b - a, c - a))
        return self._found[number]

    def _position(self, card: Card, place: int, outer: tuple[int, ...]) -> Floats:
        """Position of a point that a field names."""
        number = card.whole(place)
        grid = self._by_number.get(number)
        if grid is None:
            raise card.refuse(f"a point of the file, not {number}")
        given = np.array([_coordinates(grid, 2)])
        return self._system(self._of(grid), outer).positions(given)[0]

    @cached_property
    def _by_number(self) -> dict[int, Card]:
        return {card.whole(0): card for card in self._grids}


def _coordinates(card: Card, first: int) -> list[float]:
    return [card.real(first + i) for i in range(3)]


def _axes(card: Card, up: Floats, across: Floats) -> Floats:
    """Axes of a system in columns: the third along ``up``, the first towards ``across``."""
    side = np.cross(up, across)
    if not np.linalg.norm(side) > _FLAT * np.linalg.norm(up) * np.linalg.norm(across):
        raise card.refuse("three points that are not on one line")
    z, y = up / np.linalg.norm(up), side / np.linalg.norm(side)
    return np.stack([np.cross(y, z), y, z], axis=1)
