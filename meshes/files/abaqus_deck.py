"""Keywords of a deck of Abaqus or CalculiX, and what a part of it holds."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path, PureWindowsPath
from typing import Literal

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from cea.files import regular
from meshes.files.content import ElementBlock, Role, block, rows_of, without_nodes
from meshes.files.elements import KINDS

_KEYWORD = re.compile(rb"^[ \t]*\*((?:[^\n]*,[ \t]*\n(?![ \t]*\*))*[^\n]*)", re.MULTILINE)
"""A line that begins with one star; it goes on where it ends with a comma."""
_COMMENT = re.compile(rb"^[ \t]*\*[ \t]*\*[^\n]*\n?", re.MULTILINE)
_DEEPEST = 10
"""Files that include one another."""
_MOST = 10**8
"""Members of a set."""


@dataclass(frozen=True)
class Keyword:
    """A keyword of a deck."""

    name: str
    parameters: dict[str, str]
    data: bytes

    def needed(self, parameter: str) -> str:
        """Value of a parameter."""
        value = self.parameters.get(parameter, "")
        require(bool(value), "file", f"*{self.name}", f"a keyword with {parameter}=")
        return value

    def check(self, *known: str) -> None:
        """Refuse parameters that may change what is meant in a way that is not known."""
        for name, value in self.parameters.items():
            if name not in known:
                told = f"*{self.name}, {name}" + (f"={value}" if value else "")
                allowed = f"a keyword with parameters that are known here: {', '.join(known)}"
                raise InputError("file", told, allowed)

    @property
    def lines(self) -> list[list[str]]:
        """Fields of each line that is not empty."""
        text = self.data.decode("utf-8", "replace")
        rows = ([part.strip() for part in line.split(",")] for line in text.split("\n"))
        return [row for row in rows if any(row)]

    def nodes(self) -> tuple[Ints, Floats]:
        """Numbers and positions of nodes, (n,) and (n, 3); coordinates left out are zero."""
        rows = self._numeric_lines()
        most = max(map(len, rows), default=0)
        allowed = "a number and coordinates in each line, and a direction at most"
        require(most <= 8, "file", f"*NODE with {most} fields", allowed)
        fields = [
            [row[0], *(each or b"0" for each in row[1:4]), *[b"0"] * (4 - len(row))] for row in rows
        ]
        values = self._floats([each for row in fields for each in row]).reshape(-1, 4)
        return self._whole(values[:, 0]), values[:, 1:]

    def elements(self, size: int) -> tuple[Ints, int]:
        """Numbers and nodes of elements, (n, size + 1), and how many list more than that.

        An element ends with the line on which it has all its nodes, or with what goes on behind
        them after a comma.
        """
        width, longer, whole = size + 1, 0, True
        fields: list[bytes] = []
        record: list[bytes] = []
        joined = True
        for row in self._numeric_lines():
            goes_on = row[-1] == b""
            record += row[:-1] if goes_on else row
            extra = len(record) - width
            if extra == 0 or (extra > 0 and not goes_on):
                whole = whole and (joined or extra == 0)
                longer += extra > 0
                fields += record[:width]
                record, joined = [], True
            else:
                joined = joined and goes_on
        told = f"*ELEMENT, TYPE={self.needed('TYPE')}"
        require(whole and not record, "file", told, f"{width} numbers for each element")
        return self._whole(self._floats(fields)).reshape(-1, width), longer

    def element_numbers(self) -> Ints:
        """Numbers of elements of a type that is not known, which begin their lines, (n,)."""
        found, goes_on = [], False
        for row in self._numeric_lines():
            if not goes_on:
                found.append(row[0])
            goes_on = row[-1] == b""
        return self._whole(self._floats(found))

    def members(self) -> tuple[Ints, list[str]]:
        """Numbers that a set has, and names of other sets."""
        if "GENERATE" in self.parameters:
            ranges = [self._range(line) for line in self.lines]
            return np.concatenate([np.empty(0, dtype=np.int64), *ranges]), []
        fields = [each for line in self.lines for each in line if each]
        numbers = [each for each in fields if each.isascii() and each.isdecimal()]
        names = [each for each in fields if not (each.isascii() and each.isdecimal())]
        values = self._floats([each.encode() for each in numbers])
        return self._whole(values), list(dict.fromkeys(names))

    def _range(self, line: list[str]) -> Ints:
        """Numbers that first, last and step stand for."""
        given, step, first, last = [each for each in line if each], 0, 0, 0
        if 2 <= len(given) <= 3 and all(each.isdecimal() and len(each) < 12 for each in given):
            first, last, step = [*map(int, given), 1][:3]
        fits = step > 0 and first <= last and (last - first) // step < _MOST
        require(fits, "file", f"*{self.name}, GENERATE: {line}", "first, last and step")
        return np.arange(first, last + 1, step)

    def _numeric_lines(self) -> list[list[bytes]]:
        """Fields of each line without blanks; Fortran writes 1.D-3 as well."""
        data = self.data.translate(None, b" \t").upper().replace(b"D", b"E")
        return [line.split(b",") for line in data.split(b"\n") if line]

    def _floats(self, fields: list[bytes]) -> Floats:
        try:
            values = np.array(fields, dtype=bytes).astype(float)
        except ValueError as error:
            raise InputError("file", f"*{self.name}: {error}", "numbers in its data") from None
        require(bool(np.isfinite(values).all()), "file", f"*{self.name}", "finite numbers")
        return values

    def _whole(self, values: Floats) -> Ints:
        whole = bool((values == np.rint(values)).all() and (np.abs(values) < 2**53).all())
        require(whole, "file", f"*{self.name}", "whole numbers of nodes and elements")
        return values.astype(np.int64)


def keywords_of(file: Path) -> Iterator[Keyword]:
    """Keywords of a deck in their order, with those of files that it includes.

    Files in files are looked for in the folder of the deck, as Abaqus and CalculiX do, then in that
    of the file that names them; backslashes in their names separate folders.
    """
    yield from _keywords(file, (file,))


def _keywords(file: Path, chain: tuple[Path, ...]) -> Iterator[Keyword]:
    content = _text(file)
    places = list(_KEYWORD.finditer(content))
    ends = [match.start() for match in places] + [len(content)]
    for match, end in zip(places, ends[1:], strict=True):
        name, *parameters = match[1].decode("utf-8", "replace").replace("\n", " ").split(",")
        values = (each.partition("=") for each in parameters if each.strip())
        keyword = Keyword(
            " ".join(name.upper().split()),
            {" ".join(key.upper().split()): value.strip().strip('"') for key, _, value in values},
            content[match.end() : end],
        )
        if keyword.name == "INCLUDE":
            keyword.check("INPUT")
            other = _found(keyword.needed("INPUT"), chain)
            allowed = f"files that do not include each other, at most {_DEEPEST} deep"
            require(other not in chain and len(chain) < _DEEPEST, "file", str(other), allowed)
            yield from _keywords(other, (*chain, other))
        elif keyword.name in ("NODE", "ELEMENT", "NSET", "ELSET") and "INPUT" in keyword.parameters:
            data = _text(_found(keyword.needed("INPUT"), chain))
            told = f"*{keyword.name}, INPUT={keyword.parameters['INPUT']}"
            require(_KEYWORD.search(data) is None, "file", told, "a file of data without keywords")
            yield Keyword(keyword.name, keyword.parameters, data + b"\n" + keyword.data)
        else:
            yield keyword


def _text(file: Path) -> bytes:
    """What a file holds, without comments."""
    try:
        content = regular(file).read_bytes()
    except OSError as error:
        raise InputError("file", str(file), f"a file ({error.strerror or error})") from None
    content = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return _COMMENT.sub(b"", content)


def _found(name: str, chain: tuple[Path, ...]) -> Path:
    """A file that another one names."""
    windows = PureWindowsPath(name).as_posix()
    for folder in (chain[0].parent, chain[-1].parent):
        for each in (folder / name, folder / windows):
            try:
                if each.is_file():
                    return each.resolve()
            except (OSError, ValueError):
                continue
    allowed = (
        "a file that is there, no device or folder, in capitals and small letters as it is named"
    )
    raise InputError("file", str(chain[0].parent / windows), allowed)


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
    """What a part holds, or a deck outside of parts."""

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
            yield replace(each, nodes=first + rows_of(numbers, each.nodes, "a node"))

    def _elements(self, keyword: Keyword) -> ElementBlock:
        kind = keyword.needed("TYPE").upper()
        role, known = _known(kind)
        if not known:
            return without_nodes(kind, keyword.element_numbers(), role)
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
