"""Content of Nastran files: points in their coordinate systems, solid elements, marks of faces.

Fields of a card have 8 or 16 columns or stand between commas, in capitals or not; a tab ends a
field, ``$`` begins a comment. Lines whose first field is blank or begins with ``+`` or ``*``
continue a card. Cards for data of the scene (materials, supports, loads, the analysis) are ignored.
Any other card may change the body: it is reported as an element that was not read.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from meshes.files.content import ElementBlock, FileContent, Role, block, rows_of, without_nodes
from meshes.files.elements import CORNERS
from meshes.files.reading import text_with_included

_NAME = re.compile(r"[A-Z][A-Z0-9]*")
_REAL = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[DE]?([+-]\d+)|[DE](\d+))?", re.ASCII)
"""The exponent may stand without a letter: 1.5-2 is 0.015."""
_INCLUDE = re.compile(r"(?mi)^[ \t]*INCLUDE[ \t]*(?:'([^']*)'|\"([^\"]*)\"|([^\s$]+)).*$")
_BEGIN = re.compile(r"(?mi)^[ \t]*BEGIN\b(?![^\n$]*(?:SUPER|MODULE)).*$")
_NARROW, _WIDE = 8, 16
"""Columns of a field."""


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
        if not re.fullmatch(r"[+-]?\d{1,18}", text, re.ASCII):
            raise self.refuse("a whole number", place)
        return int(text)

    def reals(self, first: int) -> list[float]:
        """Three fields as numbers; 0 where one is empty."""
        return [self._real(place) for place in range(first, first + 3)]

    def _real(self, place: int) -> float:
        match = _REAL.fullmatch(self.text(place).upper() or "0")
        value = float(f"{match[1]}E{match[2] or match[3] or 0}") if match else np.inf
        if not abs(value) < np.inf:
            raise self.refuse("a number", place)
        return value

    def refuse(self, allowed: str, place: int | None = None) -> InputError:
        """Error of the card or one of its fields, with its name and number."""
        if place is not None:
            allowed += f" in field {place + 1} after its name, not '{self.text(place)}'"
        return InputError("file", f"{self.name} {self.text(0)}".strip(), allowed)


def cards_of(file: Path) -> Iterator[Card]:
    """Yield the cards of the bulk data of a file and of included files, in their order."""
    text = text_with_included(file, _INCLUDE, _included)
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


def _included(match: re.Match[str]) -> tuple[str, str]:
    """Path of an included file; a long one continues on the next line."""
    path = match[1] or match[2] or match[3] or ""
    return "", "".join(part.strip() for part in path.splitlines())


def _fields(line: str) -> tuple[str, list[str], str]:
    """First field in capitals, data, and continuation mark of a line."""
    line = line.partition("$")[0].rstrip()
    fields = [part.strip() for part in line.split(",")] if "," in line else _columns(line)
    count = 4 if "*" in fields[0] else 8
    marks = fields[1 + count :]
    require(len(marks) < 2, "file", line, f"at most {count} fields in a line, and a mark")
    data = (fields[1 : 1 + count] + [""] * count)[:count]
    return fields[0].upper(), data, "".join(marks).upper().lstrip("+*")


def _columns(line: str) -> list[str]:
    """Fields up to column 80; a tab ends a field, whether or not it fills its columns."""
    begins = line[:1] != " " or not line[:_NARROW].strip()
    require(begins, "file", line.strip(), "a card whose name begins in the first column")
    width = _WIDE if "*" in line[:_NARROW] else _NARROW
    first, *parts = line.split("\t")
    fields = [first[:_NARROW]]
    for part in [first[_NARROW:80], *parts] if len(first) > _NARROW else parts:
        fields += [part[i : i + width] for i in range(0, max(len(part), 1), width)]
    return [field.strip() for field in fields[: 2 + 64 // width]]


Cards = Mapping[str, Sequence[Card]]
"""Cards by their names."""


_SOLIDS = {"CTETRA": "tetrahedron", **dict.fromkeys(("CPYRAM", "CPYRA"), "pyramid")}
_SOLIDS |= {"CPENTA": "wedge", "CHEXA": "hexahedron"}
_SHELLS = dict.fromkeys(("CTRIA3", "CTRIA6", "CTRIAR"), "triangle")
_SHELLS |= dict.fromkeys(("CQUAD4", "CQUAD8", "CQUADR", "CQUAD"), "quadrilateral")
"""Shells; if they mark faces, only their corners are needed."""
_MIDDLES = {"tetrahedron": [*range(4, 10)], "pyramid": [*range(5, 13)]}
_MIDDLES |= {"wedge": [6, 7, 8, 12, 13, 14, 9, 10, 11]}
_MIDDLES |= {"hexahedron": [8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15]}
"""Fields of the middles of edges: those of vertical edges precede those of the top."""
_PROPERTIES = {"PSOLID": 3, "PLSOLID": 3, "PCOMPS": 3, "PSHELL": 2, "PCOMP": 2, "PCOMPG": 2}
"""Dimension of the elements that have a property."""
_SYSTEMS = tuple(f"CORD{way}{kind}" for way in "12" for kind in "RCS")
_OF_THE_SCENE = re.compile(
    r"P\w+|MAT\w+|SPC\w*|SPOINT|EPOINT|SUPORT\d?|SET\d|SEQGP|SNORM|ECHO\w+|EIG\w+|FREQ\d?|TSTEP\w*"
    r"|FORCE\d?|MOMENT\d?|GRAV|ACCEL\d?|RFORCE\d?|[DRST]?LOAD\w*|LSEQ|DAREA|DELAY|DPHASE|DEFORM"
    r"|TEMP\w*|TIC|NLPARM|NLPCI|NLSTEP|TAB\w+|[ABCQ]SET\d?|USET\d?|OMIT\d?"
    r"|DESVAR|DRESP\d|DCON\w+|DV[A-Z]+\d|DOPTPRM|DLINK"
)
"""Properties, materials, supports, loads, analyses, sets for output, optimisation."""

_FLAT = 1e-9
"""Sine below which an angle is zero."""


def nastran_content(file: Path) -> FileContent:
    """Read nodes and elements of a file; properties are sets, as ``PSOLID 3``."""
    cards: dict[str, list[Card]] = defaultdict(list)
    for card in cards_of(file):
        cards[card.name].append(card)
    numbers, points = _positions(cards)
    fluid = {card.whole(0) for card in cards["PSOLID"] if card.text(6).upper() == "PFLUID"}
    rows: dict[tuple[str, str, bool], list[tuple[int, int, list[int]]]] = defaultdict(list)
    for name, cell in (_SOLIDS | _SHELLS).items():
        for card in cards[name]:
            number, nodes = card.whole(0), _nodes(card, cell)
            of = card.whole(1, default=number)
            solid = name in _SOLIDS and of not in fluid
            rows[name, f"{cell}{len(nodes)}", solid].append((number, of, nodes))
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
    for name in sorted({name for name, found in cards.items() if found} - known):
        if not _OF_THE_SCENE.fullmatch(name):  # one element for each kind that is not read
            blocks.append(without_nodes(name, np.zeros(1, dtype=np.int64), "structural"))
    return FileContent(points, numbers, blocks, _sets(cards, np.array(of_elements)))


def _sets(cards: Cards, of_elements: Ints) -> dict[str, Ints]:
    """Elements of each property, from the dimension and the property of each, (n, 2)."""
    names = {
        (dim, card.whole(0)): name for name, dim in _PROPERTIES.items() for card in cards[name]
    }
    defaults = {3: "PSOLID", 2: "PSHELL"}
    keys, group = np.unique(of_elements, axis=0, return_inverse=True)
    return {
        f"{names.get((dim, number), defaults[dim])} {number}": np.flatnonzero(group == i)
        for i, (dim, number) in enumerate(keys.tolist())
    }


def _nodes(card: Card, cell: str) -> list[int]:
    """Nodes of an element in the order of :data:`meshes.files.elements.KINDS`."""
    count, places = len(CORNERS[cell]), _MIDDLES.get(cell, [])
    corners = [card.whole(2 + i) for i in range(count)]
    more = any(card.fields[2 + count :])
    middles = [card.whole(2 + i, default=0) for i in places if more]
    if not any(middles):
        return corners
    most = count + len(places)
    if not all(middles) or any(card.fields[2 + most :]):
        raise card.refuse(f"{count} or {most} points, and nothing after them")
    return corners + middles


def _positions(cards: Cards) -> tuple[Ints, Floats]:
    """Number of each point, (n,), and its position in the basic system, (n, 3)."""
    grids, defaults = cards["GRID"], cards["GRDSET"]
    require(len(grids) > 0, "file", "no GRID", "a mesh")
    require(len(defaults) < 2, "file", "GRDSET", "one of these cards at most")
    default = defaults[0].whole(1, default=0) if defaults else 0
    for card in grids:
        if any(card.fields[8:]):
            raise card.refuse("a point of eight fields at most")
    given: dict[int, tuple[Card, int]] = {}
    for card in (card for name in _SYSTEMS for card in cards[name]):
        # CORD1 cards hold one or two systems.
        for start in (0, 4) if card.name[4] == "1" and card.text(4) else (0,):
            number = card.whole(start)
            fits = number > 0 and number not in given
            require(fits, "file", f"{card.name} {number}", "a number of its own, from 1")
            given[number] = card, start
    numbers = np.array([card.whole(0) for card in grids], dtype=np.int64)
    systems = np.array([card.whole(1, default=default) for card in grids])
    points = np.array([card.reals(2) for card in grids])
    grid_of = {number: i for i, number in enumerate(numbers.tolist())}

    def basic(number: int, x: Floats, outer: tuple[int, ...] = ()) -> Floats:
        """Positions in the basic system, (n, 3), of coordinates in another; angles in degrees.

        ``outer`` are the systems that are defined in terms of this one.
        """
        if number == 0:
            return x
        require(number in given, "file", f"CP {number}", "a coordinate system of the file")
        card, start = given[number]
        if number in outer:
            raise card.refuse("a coordinate system that is not defined by itself")
        if card.name[4] == "1":
            named = [card.whole(start + i) for i in (1, 2, 3)]
            if unknown := [each for each in named if each not in grid_of]:
                raise card.refuse(f"a point of the file, not {unknown[0]}")
            rows = [grid_of[each] for each in named]
            corners = [(int(systems[row]), own[row]) for row in rows]
        else:
            corners = [(card.whole(1, default=0), np.array(card.reals(i))) for i in (2, 5, 8)]
        three = [basic(of, corner[None], (*outer, number))[0] for of, corner in corners]
        axes = _axes(*three)
        if axes is None:
            raise card.refuse("three points that are not on one line")
        return three[0] + _cartesian(card.name[5], x) @ axes

    own = points.copy()
    for number in np.unique(systems).tolist():
        inside = systems == number
        points[inside] = basic(number, own[inside])
    return numbers, points


def _axes(origin: Floats, on_axis: Floats, in_plane: Floats) -> Floats | None:
    """Axes x, y, z of a system, (3, 3), from its origin and points on z and in the plane x, z."""
    up, across = on_axis - origin, in_plane - origin
    side = np.cross(up, across)
    if not np.linalg.norm(side) > _FLAT * np.linalg.norm(up) * np.linalg.norm(across):
        return None
    z, y = up / np.linalg.norm(up), side / np.linalg.norm(side)
    return np.stack([np.cross(y, z), y, z])


def _cartesian(kind: str, x: Floats) -> Floats:
    """Cartesian from Cartesian (R), cylindrical (C) or spherical (S) coordinates, (n, 3)."""
    a, b, c = x[:, 0], np.radians(x[:, 1]), x[:, 2]
    if kind == "C":
        return np.stack([a * np.cos(b), a * np.sin(b), c], axis=1)
    if kind == "S":
        c, r = np.radians(c), a * np.sin(b)
        return np.stack([r * np.cos(c), r * np.sin(c), a * np.cos(b)], axis=1)
    return x
