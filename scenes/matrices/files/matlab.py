"""Matrices in MATLAB's format of versions 5 to 7.2, read within the bounds of the file.

A broken file of this format can make scipy's reader crash the process. Here every size is held
against what is left of the file before it is used. A file is a header and elements; an element is a
tag, its kind and size, and data; a matrix is an element of elements: flags, dimensions, name,
numbers.
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from scipy.sparse import csc_array

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
}  # fmt: skip
"""Types of numbers by the kind of their element."""
_SPARSE, _NUMBERS = 5, range(6, 16)
"""Classes of variables that are matrices."""
_COMPLEX = 0x0800


@dataclass(frozen=True)
class Variable:
    """A matrix as it lies in a file.

    Parameters
    ----------
    name
        Its name.
    shape
        Its dimensions.
    sparse
        Whether it is sparse.
    complex
        Whether it is complex.
    parts
        Its numbers: of a sparse matrix rows, ends of columns, values; else the values by columns.
    """

    name: str
    shape: tuple[int, ...]
    sparse: bool
    complex: bool
    parts: tuple[Any, ...]

    def matrix(self) -> Any:
        """The matrix, sparse or an array.

        Raises
        ------
        ValueError
            When its parts do not fit its shape.
        """
        if not self.sparse:
            (values,) = self.parts[:1]
            if len(values) != prod(self.shape):
                raise ValueError(f"{len(values)} numbers in a matrix of {self.shape}")
            return values.reshape(self.shape, order="F")
        rows, ends, values = self.parts[:3]
        count = int(ends[-1]) if len(ends) else -1
        if not 0 <= count <= min(len(rows), len(values)):
            raise ValueError("entries and columns disagree")
        whole = (values[:count], rows[:count].astype(np.int64), ends.astype(np.int64))
        matrix = csc_array(whole, shape=self.shape)
        matrix.check_format(full_check=True)
        return matrix


def read_variables(content: bytes) -> list[Variable]:
    """Matrices of a file; text, cells, structures and objects are passed over.

    Parameters
    ----------
    content
        The file.

    Raises
    ------
    ValueError
        When it is no such file, or broken.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[_HEADER - 2 : _HEADER])
    if order is None:
        raise ValueError("its header names no order of bytes")
    found = []
    for kind, data in _elements(content[_HEADER:], order, padded=False):
        if kind == _COMPRESSED:
            inner = _unpacked(data)
            kind, data = next(_elements(inner, order), (0, b""))
        if kind != _MATRIX:
            raise ValueError(f"an element of kind {kind} is no variable")
        variable = _variable(data, order)
        if variable is not None:
            found.append(variable)
    return found


def _unpacked(data: bytes) -> bytes:
    try:
        return zlib.decompress(data)
    except zlib.error as error:
        raise ValueError(str(error)) from None


def _elements(content: bytes, order: str, *, padded: bool = True) -> Iterator[tuple[int, bytes]]:
    """Kind and data of each element.

    Parameters
    ----------
    content
        Elements one after the other.
    order
        Order of bytes.
    padded
        Whether elements begin at multiples of eight bytes.
    """
    place = 0
    while place + 8 <= len(content):
        kind, size = (int(n) for n in np.frombuffer(content, f"{order}u4", 2, place))
        if kind >> 16:  # a small one: its size in the upper half, its data in the tag
            kind, size = kind & 0xFFFF, kind >> 16
            begin, place = place + 4, place + 8
            if size > 4:
                raise ValueError("a small element is too large")
        else:
            begin = place + 8
            place = begin + size + (-size % 8 if padded else 0)
        if begin + size > len(content):
            raise ValueError("its end is missing")
        yield kind, content[begin : begin + size]
    if place < len(content):
        raise ValueError("its end is missing")


def _variable(data: bytes, order: str) -> Variable | None:
    """A variable if it is a matrix."""
    elements = _elements(data, order)
    flags = _numbers(next(elements, None), order)
    shape = _numbers(next(elements, None), order)
    _, name = next(elements, (0, b""))
    if len(flags) < 2:
        raise ValueError("a variable without flags")
    kind = int(flags[0]) & 0xFF
    if kind != _SPARSE and kind not in _NUMBERS:
        return None
    parts = tuple(_numbers(element, order) for element in elements)
    if len(parts) < (3 if kind == _SPARSE else 1):
        raise ValueError("a variable without numbers")
    return Variable(
        name=name.decode("ascii", "replace"),
        shape=tuple(int(n) for n in shape),
        sparse=kind == _SPARSE,
        complex=bool(int(flags[0]) & _COMPLEX),
        parts=parts,
    )


def _numbers(element: tuple[int, bytes] | None, order: str) -> Any:
    if element is None or element[0] not in _TYPES:
        raise ValueError("an element that should hold numbers has none")
    kind = np.dtype(f"{order}{_TYPES[element[0]]}")
    if len(element[1]) % kind.itemsize:
        raise ValueError("an element ends within a number")
    return np.frombuffer(element[1], kind)
