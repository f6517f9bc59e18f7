"""Cards of Nastran bulk data: names and fields, however they are written.

Fields have 8 or 16 columns or stand between commas, in capitals or not; a tab ends a field, ``$``
begins a comment. Lines whose first field is blank or begins with ``+`` or ``*`` continue a card.
"""

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from cea.errors import InputError, require
from meshes.files.state import checked_state

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
        """A field as a whole number.

        Raises
        ------
        InputError
            When it is none, or empty without a default.
        """
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
        """A field as a number; 0 where it is empty.

        Raises
        ------
        InputError
            When it is none.
        """
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
    """Cards of the bulk data of a file and of those that it includes, in their order.

    Raises
    ------
    InputError
        When a line is none of a card, or a file cannot be read.
    """
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
