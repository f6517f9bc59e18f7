"""Keywords of a deck, each with its parameters and data."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cea.errors import InputError, require
from cea.files import regular

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

_KEYWORD = re.compile(rb"^[ \t]*\*[ \t]*(?![ \t]*\*)((?:[^\n]*,[ \t]*\n)*[^\n]*)", re.MULTILINE)
"""A line that begins with one star; it goes on where it ends with a comma."""
_COMMENT = re.compile(rb"^[ \t]*\*\*[^\n]*", re.MULTILINE)
_DEEPEST = 10
"""Files that include one another."""


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
        Its lines, without comments.
    """

    name: str
    parameters: dict[str, str]
    data: bytes

    def needed(self, parameter: str) -> str:
        """Value of a parameter.

        Raises
        ------
        InputError
            Where it lacks.
        """
        value = self.parameters.get(parameter, "")
        require(bool(value), "file", f"*{self.name}", f"a keyword with {parameter}=")
        return value

    @property
    def lines(self) -> list[list[str]]:
        """Fields of each line that is not empty."""
        text = self.data.decode("utf-8", "replace")
        rows = ([part.strip() for part in line.split(",")] for line in text.splitlines())
        return [row for row in rows if any(row)]

    def numbers(self) -> Floats:
        """All numbers of its data, in a row.

        Raises
        ------
        InputError
            Where something else stands there.
        """
        # Fortran writes 1.D-3 as well.
        fields = self.data.replace(b",", b" ").replace(b"D", b"E").replace(b"d", b"e").split()
        try:
            values = np.array(fields, dtype="S32").astype(float)
        except ValueError as error:
            raise InputError("file", f"*{self.name}: {error}", "numbers in its data") from None
        require(bool(np.isfinite(values).all()), "file", f"*{self.name}", "finite numbers")
        return values

    def whole_numbers(self) -> Ints:
        """The same as whole numbers."""
        values = self.numbers()
        whole = bool((values == np.rint(values)).all() and (np.abs(values) < 2**53).all())
        require(whole, "file", f"*{self.name}", "whole numbers in its data")
        return values.astype(np.int64)


def keywords_of(file: Path, depth: int = 0) -> Iterator[Keyword]:
    """Keywords of a deck in their order, with those of files that it includes.

    Raises
    ------
    InputError
        When a file cannot be read, or files include one another too deeply.
    """
    require(depth < _DEEPEST, "file", str(file), f"files that include each other {_DEEPEST} deep")
    try:
        content = regular(file).read_bytes().replace(b"\r\n", b"\n")
    except OSError as error:
        raise InputError("file", str(file), f"a file ({error.strerror or error})") from None
    places = list(_KEYWORD.finditer(content))
    ends = [match.start() for match in places] + [len(content)]
    for match, end in zip(places, ends[1:], strict=True):
        name, *parameters = match[1].decode("utf-8", "replace").replace("\n", " ").split(",")
        values = (parameter.partition("=") for parameter in parameters)
        keyword = Keyword(
            " ".join(name.upper().split()),
            {key.strip().upper(): value.strip().strip('"') for key, _, value in values},
            _COMMENT.sub(b"", content[match.end() : end]),
        )
        if keyword.name == "INCLUDE":
            yield from keywords_of(file.parent / keyword.needed("INPUT"), depth + 1)
        else:
            yield keyword
