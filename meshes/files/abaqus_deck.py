"""Keywords of a deck of Abaqus or CalculiX: their parameters, nodes, elements, members of sets."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from cea.arrays import Floats, Ints
from cea.errors import InputError, require
from meshes.files.reading import text_with_included

_KEYWORD = re.compile(r"^[ \t]*\*((?:[^\n]*,[ \t]*\n(?![ \t]*\*))*[^\n]*)", re.MULTILINE)
"""A line that begins with one star, continued after a final comma."""
_COMMENT = re.compile(r"^[ \t]*\*[ \t]*\*[^\n]*\n?", re.MULTILINE)
_MOST = 10**8
"""Largest number of members of a range."""


@dataclass(frozen=True)
class Keyword:
    """A keyword of a deck."""

    name: str
    parameters: dict[str, str]
    data: str

    def needed(self, parameter: str) -> str:
        """Value of a required parameter."""
        value = self.parameters.get(parameter, "")
        require(bool(value), "file", f"*{self.name}", f"a keyword with {parameter}=")
        return value

    def check(self, *known: str) -> None:
        """Refuse unknown parameters, which may change the meaning of the keyword."""
        for name, value in self.parameters.items():
            if name not in known:
                told = f"*{self.name}, {name}" + (f"={value}" if value else "")
                allowed = f"a keyword with parameters that are known here: {', '.join(known)}"
                raise InputError("file", told, allowed)

    @property
    def lines(self) -> list[list[str]]:
        """Fields of each line that is not empty."""
        rows = ([field.strip() for field in line.split(",")] for line in self.data.split("\n"))
        return [row for row in rows if any(row)]

    def nodes(self) -> tuple[Ints, Floats]:
        """Numbers and positions of nodes, (n,) and (n, 3); coordinates left out are zero."""
        rows = self.lines
        most = max(map(len, rows), default=0)
        allowed = "a number and coordinates in each line, and a direction at most"
        require(most <= 8, "file", f"*NODE with {most} fields", allowed)
        fields = [field or "0" for row in rows for field in (*row, "", "", "")[:4]]
        values = self._numbers(fields).reshape(-1, 4)
        return self._whole(values[:, 0]), values[:, 1:]

    def elements(self, size: int) -> Ints:
        """Numbers and nodes of elements, (n, size + 1); each begins a line."""
        rows = [row[:-1] if row[-1] == "" else row for row in self.lines]
        ends = np.cumsum([0, *map(len, rows)])
        whole = ends[-1] % (size + 1) == 0 and set(range(0, ends[-1], size + 1)) <= {*ends.tolist()}
        told = f"*ELEMENT, TYPE={self.needed('TYPE')}"
        require(bool(whole), "file", told, f"{size + 1} numbers for each element")
        fields = [field for row in rows for field in row]
        return self._whole(self._numbers(fields)).reshape(-1, size + 1)

    def first_numbers(self) -> Ints:
        """First number of each line that does not continue one with a comma at its end, (n,)."""
        pairs = pairwise([["first"], *self.lines])
        return self._whole(self._numbers([row[0] for before, row in pairs if before[-1]]))

    def members(self) -> tuple[Ints, list[str]]:
        """Numbers of the members of a set, and names of sets in it."""
        if "GENERATE" in self.parameters:
            ranges = [self._range([each for each in line if each]) for line in self.lines]
            return np.concatenate([np.empty(0, dtype=np.int64), *ranges]), []
        fields = [each for line in self.lines for each in line if each]
        names = [each for each in fields if not is_number(each)]
        numbers = self._whole(self._numbers([each for each in fields if is_number(each)]))
        return numbers, list(dict.fromkeys(names))

    def _range(self, given: list[str]) -> Ints:
        """Numbers from first to last by a step."""
        step, first, last = 0, 0, 0
        if 2 <= len(given) <= 3 and all(is_number(each) for each in given):
            first, last, step = [*map(int, given), 1][:3]
        fits = step > 0 and first <= last < 2**62 and (last - first) // step < _MOST
        require(fits, "file", f"*{self.name}, GENERATE: {given}", "first, last and step")
        return np.arange(first, last + 1, step)

    def _numbers(self, fields: list[str]) -> Floats:
        """Fields as numbers, also in the form 1.D-3 of Fortran."""
        try:
            values = np.array([float(each.replace("D", "E").replace("d", "e")) for each in fields])
        except ValueError as error:
            raise InputError("file", f"*{self.name}: {error}", "numbers in its data") from None
        require(bool(np.isfinite(values).all()), "file", f"*{self.name}", "finite numbers")
        return values

    def _whole(self, values: Floats) -> Ints:
        whole = bool((values == np.rint(values)).all() and (np.abs(values) < 2**53).all())
        require(whole, "file", f"*{self.name}", "whole numbers of nodes and elements")
        return values.astype(np.int64)


def is_number(text: str) -> bool:
    """Whether a field is the number of a node or an element rather than the name of a set."""
    return text.isascii() and text.isdecimal()


def keywords_of(file: Path) -> Iterator[Keyword]:
    """Yield the keywords of a deck in their order, with those of included files."""
    text = text_with_included(file, _KEYWORD, _included, lambda each: _COMMENT.sub("", each))
    _, *parts = _KEYWORD.split(text)
    for head, data in zip(parts[::2], parts[1::2], strict=True):
        yield _keyword(head, data)


def _keyword(head: str, data: str = "") -> Keyword:
    """A keyword from its line, joined with its continuation lines."""
    name, *parameters = head.replace("\n", " ").split(",")
    values = (each.partition("=") for each in parameters if each.strip())
    found = {" ".join(key.upper().split()): value.strip().strip('"') for key, _, value in values}
    return Keyword(" ".join(name.upper().split()), found, data)


def _included(match: re.Match[str]) -> tuple[str, str] | None:
    """Text to keep of a keyword that includes a file, and the file; None of other keywords."""
    keyword = _keyword(match[1])
    if keyword.name == "INCLUDE":
        keyword.check("INPUT")
        return "", keyword.needed("INPUT")
    if keyword.name in ("NODE", "ELEMENT", "NSET", "ELSET") and "INPUT" in keyword.parameters:
        return f"{match[0]}\n", keyword.needed("INPUT")
    return None
