"""NURBS patches of files: the .json of splinepy and the .xml of G+Smo.

They hold plain lists of numbers. Both are read here, as splinepy ends the program over files that
are not whole.
"""

import base64
import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from meshes.files.content import Floats


class Spline(NamedTuple):
    """A patch in the unit of its file.

    Parameters
    ----------
    degrees
        Degree along each parameter.
    knots
        Knots along each parameter.
    points
        Control points, (n1, ..., dim), not multiplied by the weights.
    weights
        Weights, (n1, ...); None where all are 1.
    """

    degrees: tuple[int, ...]
    knots: tuple[tuple[float, ...], ...]
    points: Floats
    weights: Floats | None


class FileSplines(NamedTuple):
    """Patches of a file, and the faces (patch, axis, side) that it names."""

    splines: tuple[Spline, ...]
    faces: Mapping[str, tuple[tuple[int, int, int], ...]]


def json_splines(text: str) -> FileSplines:
    """Patches of a file of splinepy; it names no faces.

    Raises
    ------
    ValueError, LookupError, TypeError
        When it is not as the format has it.
    """
    data = json.loads(text)
    packed = bool(data["Base64Encoding"])
    return FileSplines(tuple(_of_json(one, packed) for one in data["SplineList"]), {})


def _of_json(data: Mapping[str, Any], packed: bool) -> Spline:
    degrees = tuple(int(p) for p in data["degrees"])
    given = data.get("knot_vectors")
    if given is None:  # Bezier patches
        given = [[0.0] * (p + 1) + [1.0] * (p + 1) for p in degrees]
    points, weights = data["control_points"], data.get("weights")
    if packed:
        points = _unpacked(points).reshape(-1, int(data["dim"]))
        weights = None if weights is None else _unpacked(weights)
    return _spline(degrees, given, np.asarray(points, dtype=float), weights)


def _unpacked(text: str) -> Floats:
    return np.frombuffer(base64.b64decode(text), dtype=np.float64)


def xml_splines(text: str) -> FileSplines:
    """Patches of a file of G+Smo, and its named boundaries.

    Raises
    ------
    ValueError, LookupError, TypeError, AttributeError, SyntaxError
        When it is not as the format has it.
    """
    root = ElementTree.fromstring(text)
    splines: list[Spline] = []
    place: dict[str | None, int] = {}
    for geometry in root.iter("Geometry"):
        place[geometry.get("id")] = len(splines)
        splines.append(_of_xml(geometry))
    faces: dict[str, tuple[tuple[int, int, int], ...]] = {}
    for name, patch, side in _boundaries(root):
        end = place[str(patch)], (side - 1) // 2, (side - 1) % 2
        faces[name] = (*faces.get(name, ()), end)
    return FileSplines(tuple(splines), faces)


def _of_xml(geometry: ElementTree.Element) -> Spline:
    vectors = {}
    for basis in geometry.iter("Basis"):
        knots = basis.find("KnotVector")
        if knots is not None:
            degree = int(knots.attrib["degree"])
            vectors[int(basis.attrib.get("index", 0))] = degree, _numbers(knots)
    degrees, knots_of = zip(*(vectors[axis] for axis in range(len(vectors))), strict=True)
    coefficients = next(geometry.iter("coefs"))
    points = _numbers(coefficients).reshape(-1, int(coefficients.attrib["geoDim"]))
    weights = next(geometry.iter("weights"), None)
    return _spline(degrees, knots_of, points, None if weights is None else _numbers(weights))


def _numbers(element: ElementTree.Element) -> Floats:
    """Numbers of an element, written out or packed."""
    text, form = element.text or "", element.get("format", "ASCII").lower()
    if form == "b64float64":
        return _unpacked(text.strip())
    if form != "ascii":
        raise ValueError(form)
    return np.array(text.split(), dtype=float)


def _boundaries(root: ElementTree.Element) -> Iterator[tuple[str, int, int]]:
    """Name, patch and side of each part of a named boundary; sides count the ends of parameters."""
    for boundary in root.iter("boundary"):
        name = boundary.get("name")
        numbers = [int(each) for each in (boundary.text or "").split()]
        if name:
            for patch, side in zip(numbers[::2], numbers[1::2], strict=True):
                yield name, patch, side


def _spline(degrees: Any, knots: Any, points: Floats, weights: Any) -> Spline:
    """A patch whose points run fastest along the first parameter."""
    vectors = tuple(tuple(float(k) for k in vector) for vector in knots)
    shape = tuple(len(k) - p - 1 for k, p in zip(vectors, degrees, strict=True))
    order = tuple(range(len(shape)))[::-1]
    net = points.reshape(*shape[::-1], points.shape[-1]).transpose(*order, len(shape))
    if weights is not None:
        weights = np.asarray(weights, dtype=float).reshape(shape[::-1]).T
    return Spline(tuple(degrees), vectors, net, weights)
