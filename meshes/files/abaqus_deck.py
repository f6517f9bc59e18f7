"""Keywords of a deck of Abaqus or CalculiX, each with its parameters and data."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

import numpy as np

from cea.errors import InputError, require
from cea.files import regular
from meshes.files.content import Floats, Ints

_KEYWORD = re.compile(rb"^[ \t]*\*((?:[^\n]*,[ \t]*\n(?![ \t]*\*))*[^\n]*)", re.MULTILINE)
"""A line that begins with one star; it goes on where it ends with a comma."""
_COMMENT = re.compile(rb"^[ \t]*\*[ \t]*\*[^\n]*\n?", re.MULTILINE)
_DEEPEST = 10
"""Files that include one another."""
_MOST = 10**8
"""Members of a set."""


@dataclass(frozen=True)
class Keyword:
    """A keyword of a deck.

    Parameters
    ----------
    name
        In capitals, without blanks around it.
    parameters
        Values by names in capitals; without a value, an empty text.
    data
        Its lines, without comments; those of the file that INPUT names before its own.
    """

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
