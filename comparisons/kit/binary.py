"""Arrays of numbers as text in a page: quantised, compressed, one after the other."""

from base64 import b64encode
from dataclasses import dataclass, field
from gzip import compress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_TYPES = {"uint16": np.uint16, "int16": np.int16, "uint32": np.uint32}
_ALIGNED = 4
"""Bytes at whose multiples arrays begin, as typed arrays of a browser want it."""
STEPS = 2047
"""Steps of a quantised number on either side of zero: finer ones are noise to a compressor."""


@dataclass
class Binary:
    """Arrays that a page holds, and reads by their place."""

    _parts: list[bytes] = field(default_factory=list)
    _size: int = 0

    def add(self, values: NDArray[Any], kind: str) -> dict[str, Any]:
        """Keep an array.

        Parameters
        ----------
        values
            The numbers, of any shape.
        kind
            ``uint16``, ``int16`` or ``uint32``.

        Returns
        -------
        dict
            Its type, and where it begins (bytes) and how many numbers it has.
        """
        content = np.ascontiguousarray(values, dtype=_TYPES[kind]).tobytes()
        return {"type": kind, "at": self.append(content), "length": int(np.size(values))}

    def append(self, content: bytes) -> int:
        """Keep bytes, and tell where they begin."""
        begin = self._size
        self._parts.append(content + bytes(-len(content) % _ALIGNED))
        self._size += len(self._parts[-1])
        return begin

    def content(self) -> bytes:
        """Everything."""
        return b"".join(self._parts)

    def add_numbers(self, values: ArrayLike) -> dict[str, Any]:
        """Keep whole numbers from 0 on in as few bytes as they need."""
        numbers = np.asarray(values)
        small = numbers.size == 0 or int(numbers.max()) < 2**16
        return self.add(numbers, "uint16" if small else "uint32")

    def text(self) -> str:
        """Everything, compressed with gzip, in base64."""
        return packed(self.content())


def packed(content: bytes) -> str:
    """Bytes compressed with gzip, in base64; the same for the same bytes."""
    return b64encode(compress(content, 9, mtime=0)).decode()


def quantised(values: NDArray[Any], largest: float) -> NDArray[np.int16]:
    """Numbers in :data:`STEPS` steps on either side of zero, the last at the largest."""
    return np.round(values * (STEPS / (largest or 1.0))).astype(np.int16)
