"""Lines of a deck: keywords, comments, tables of numbers."""

from collections.abc import Iterable, Sequence
from io import StringIO

import numpy as np
from numpy.typing import ArrayLike

from cea.mesh import Floats, Ints

_PER_LINE = 12
"""Numbers of a set on one line; 16 are allowed."""


def keyword(name: str, **parameters: object) -> str:
    """A keyword line; underscores in names of parameters stand for spaces."""
    words = [f"{key.replace('_', ' ')}={value}" for key, value in parameters.items()]
    return ", ".join([f"*{name}", *words])


def comments(lines: Iterable[str]) -> list[str]:
    """Comment lines; texts of several lines stay comments."""
    return [f"** {part}".rstrip() for line in lines for part in line.splitlines()]


def number(value: float) -> str:
    """A number in at most 20 characters, all that CalculiX reads of one."""
    text = repr(float(value))
    return text if len(text) <= 20 else f"{value:.13E}"


def numbers(values: Iterable[float]) -> str:
    """Numbers on a line."""
    return ", ".join(map(number, values))


def node_lines(first: int, points: Floats) -> list[str]:
    """A line for each node: its number and coordinates, with 14 digits; z = 0 in the plane."""
    x = np.zeros((len(points), 3))
    x[:, : points.shape[1]] = points
    return _table(np.column_stack([np.arange(first, first + len(x)), x]), "%d" + ",%.13E" * 3)


def element_lines(first: int, elements: Ints) -> list[str]:
    """A line for each element: its number and nodes."""
    rows = np.column_stack([np.arange(first, first + len(elements)), elements])
    return _table(rows, ",".join(["%d"] * rows.shape[1]))


def set_lines(members: Ints) -> list[str]:
    """Members of a set, some to a line."""
    return [
        ",".join(map(str, members[i : i + _PER_LINE].tolist()))
        for i in range(0, len(members), _PER_LINE)
    ]


def face_lines(elements: Ints, faces: Ints) -> list[str]:
    """A line for each face of a surface: element and face."""
    return _table(np.column_stack([elements, faces]), "%d,S%d")


def value_lines(nodes: Ints, components: Ints, values: Floats) -> list[str]:
    """A line for each prescribed displacement: node, component twice, value."""
    return _table(np.column_stack([nodes, components, components, values]), "%d,%d,%d,%.13E")


def _table(rows: ArrayLike, form: str) -> list[str]:
    text = StringIO()
    np.savetxt(text, np.asarray(rows), fmt=form)
    return text.getvalue().splitlines()


def joined(parts: Iterable[Sequence[str]]) -> str:
    """Text of groups of lines."""
    return "\n".join(line for part in parts for line in part) + "\n"
