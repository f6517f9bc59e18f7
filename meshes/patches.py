"""Geometry given as NURBS patches: knots, control points and weights, checked before use.

They come from the scene or from a file of splinepy (.json) or G+Smo (.xml). Files are read here,
since splinepy ends the program if a file is incomplete.
"""

import base64
import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np

from cea.arrays import Floats, finite_numbers
from cea.errors import require
from meshes.files.content import first_of_near
from meshes.mesh_file import Unit, in_metres, is_fit

Face = tuple[int, int, int]
Faces = Mapping[str, tuple[Face, ...]]

_SAME = 1e-10
"""Distance of neighbouring control points, relative to the largest, below which they coincide."""
_READERS = {".json": "meshes.patches.splinepy_patches", ".xml": "meshes.patches.gismo_patches"}
_LARGEST = 2**28
"""Largest size of a file (bytes)."""


@dataclass(frozen=True)
class GivenPatch:
    """One NURBS patch as plain numbers.

    Parameters
    ----------
    degrees
        Degree along each of its two (plane strain) or three parameters.
    knots
        Open knot vector along each parameter, over any range; inner knots may repeat up to the
        degree, and stay as often in the refined patch.
    control_points
        Control points (m) in nested lists of shape (n1, ..., dim), not multiplied by the weights.
    weights
        Weights in nested lists of shape (n1, ...); all 1 by default.

    Raises
    ------
    InputError
        When numbers do not fit together, knots do not rise, or weights are not positive.
    """

    degrees: tuple[int, ...]
    knots: tuple[tuple[float, ...], ...]
    control_points: tuple[Any, ...]
    weights: tuple[Any, ...] | None = None

    def __post_init__(self) -> None:
        dim = len(self.degrees)
        degrees_fit = dim in (2, 3) and all(p >= 1 for p in self.degrees)
        require(degrees_fit, "degrees", self.degrees, "two or three whole numbers from 1")
        allowed = f"{dim} knot vectors, as many as degrees"
        require(len(self.knots) == dim, "knots", self.knots, allowed)
        for axis, (knots, p) in enumerate(zip(self.knots, self.degrees, strict=True)):
            _check_knots(np.asarray(knots, dtype=float), p, f"knots[{axis}]", knots)
        counts = tuple(len(k) - p - 1 for k, p in zip(self.knots, self.degrees, strict=True))
        nested = "nested lists of finite numbers, equally long at each depth"
        shape = finite_numbers(self.control_points, "control_points", nested).shape
        allowed = f"shape {(*counts, dim)}: knots less degree less 1 along each parameter"
        require(shape == (*counts, dim), "control_points", shape, allowed)
        if self.weights is not None:
            weights = finite_numbers(self.weights, "weights", nested)
            require(weights.shape == counts, "weights", weights.shape, f"shape {counts}")
            require(bool(np.all(weights > 0)), "weights", float(weights.min()), "positive numbers")

    @property
    def points(self) -> Floats:
        """Control points (m), shape (n1, ..., dim)."""
        return np.asarray(self.control_points, dtype=float)

    @property
    def shortest(self) -> float:
        """Shortest distance of neighbouring control points that do not coincide (m)."""
        dim = len(self.degrees)
        steps = [np.linalg.norm(np.diff(self.points, axis=k), axis=-1).ravel() for k in range(dim)]
        every = np.concatenate(steps)
        return float(every[every > _SAME * every.max()].min(initial=np.inf))

    @property
    def point_weights(self) -> Floats:
        """Weights, shape (n1, ...)."""
        if self.weights is None:
            return np.ones(self.points.shape[:-1])
        return np.asarray(self.weights, dtype=float)


class _OfPatches(ABC):
    """Properties of patches from a scene or from a file."""

    @property
    @abstractmethod
    def given(self) -> "Patches":
        """The patches (m)."""

    @property
    def directions(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return ("u", "v", "w")[: len(self.given.patches[0].degrees)]

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return tuple(self.given.faces)

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the scaled parameters."""
        return ((0.0, 1.0),) * len(self.directions)


@dataclass(frozen=True)
class Patches(_OfPatches):
    """Any conforming NURBS patches, joined with continuity 0 where their faces coincide.

    The directions u, v (and w) of the shape are the parameters of each patch in their own order,
    each scaled to the range 0 to 1: elements divide this range of every patch evenly, beside the
    knots it has. Where patches meet with their parameters in another order, degree and elements
    must be the same along those that meet.

    Parameters
    ----------
    patches
        The patches, in any relative orientation.
    faces
        Faces [patch, axis, side] of each named surface; side 0 is where the parameter is least.
    merge_nodes
        Distance (m) within which control points are merged; by default none are.

    Raises
    ------
    InputError
        When patches differ in dimension, faces do not exist, or merge_nodes is not small beside the
        distances of control points.
    """

    patches: tuple[GivenPatch, ...]
    faces: dict[str, tuple[Face, ...]]
    merge_nodes: float | None = None
    shape: Literal["patches"] = "patches"

    def __post_init__(self) -> None:
        dims = sorted({len(patch.degrees) for patch in self.patches})
        require(len(dims) == 1, "patches", dims, "at least one patch, all of one dimension")
        count, dim = len(self.patches), dims[0]
        for name, ends in self.faces.items():
            real = [0 <= p < count and 0 <= a < dim and s in (0, 1) for p, a, s in ends]
            fits = bool(real) and all(real) and len(set(map(tuple, ends))) == len(ends)
            allowed = f"different [patch below {count}, axis below {dim}, side 0 or 1]"
            require(fits, f"faces[{name}]", ends, allowed)
        if self.merge_nodes is not None:
            shortest = min(patch.shortest for patch in self.patches)
            fits = 0 < self.merge_nodes < shortest / 2
            allowed = f"above 0, less than half the shortest step of a net, {shortest:.3g} m"
            require(fits, "merge_nodes", self.merge_nodes, allowed)

    @cached_property
    def nets(self) -> tuple[Floats, ...]:
        """Control points of each patch (m), shape (n1, ..., dim), with near ones merged."""
        nets = [patch.points for patch in self.patches]
        if self.merge_nodes is None:
            return tuple(nets)
        every = np.concatenate([net.reshape(-1, net.shape[-1]) for net in nets])
        first = first_of_near(every, self.merge_nodes)
        parts = np.split(every[first], np.cumsum([net[..., 0].size for net in nets])[:-1])
        return tuple(part.reshape(net.shape) for part, net in zip(parts, nets, strict=True))

    @property
    def given(self) -> "Patches":
        """The patches themselves."""
        return self


def _check_knots(knots: Floats, p: int, field: str, given: tuple[float, ...]) -> None:
    """Refuse knot vectors that are not open, do not rise, or tear the patch."""
    long_enough, finite = len(knots) >= 2 * p + 2, bool(np.isfinite(knots).all())
    rise = long_enough and finite and bool(np.all(np.diff(knots) >= 0))
    require(rise, field, given, f"at least {2 * p + 2} finite numbers that do not fall")
    open_ends = knots[0] == knots[p] < knots[p + 1] and knots[-p - 2] < knots[-p - 1] == knots[-1]
    require(bool(open_ends), field, given, f"first and last knot exactly {p + 1} times")
    often = int(np.unique(knots[p + 1 : -p - 1], return_counts=True)[1].max(initial=0))
    require(often <= p, field, given, f"inner knots at most {p} times: continuity 0 at least")


@dataclass(frozen=True)
class NurbsFile(_OfPatches):
    """A body of the NURBS patches of a file, joined where their faces coincide.

    Formats are the .json of splinepy and the .xml of G+Smo (gismo). Degrees are raised and knots
    inserted as the mesh says, as those of :class:`meshes.patches.Patches`; what the file has stays.

    Parameters
    ----------
    file
        The file; in a scene file, relative to it.
    unit
        Unit of length of the file: m, cm, mm, um, in or ft, needed in a scene in SI units. Left out
        in a scene with ``units = "other"``: lengths of the file are then taken as they are.
    faces
        Faces [patch, axis, side] of each named surface; side 0 is where the parameter is least.
        Boundaries that a file of G+Smo names need not be listed here.
    merge_nodes
        Distance, in the unit of the file, within which control points are merged; by default none
        are.

    Raises
    ------
    InputError
        When the file cannot be read, or holds no patches that make a body.
    """

    file: str
    unit: Unit | None = None
    faces: dict[str, tuple[Face, ...]] = field(default_factory=dict)
    merge_nodes: float | None = None
    shape: Literal["nurbs_file"] = "nurbs_file"

    def __post_init__(self) -> None:
        require(bool(self.given.patches), "file", self.file, "patches")

    @cached_property
    def given(self) -> Patches:
        """Patches of the file (m)."""
        from meshes.files.reading import read_once

        given, named = read_once(Path(self.file), "a file of patches", _READERS, largest=_LARGEST)
        faces = {name: ends for name, ends in named.items() if is_fit(name)} | self.faces
        lengths = [in_metres(patch.points, self.unit).tolist() for patch in given]
        patches = [replace(p, control_points=tuple(x)) for p, x in zip(given, lengths, strict=True)]
        near = self.merge_nodes
        if near is not None:
            near = float(in_metres(np.array(near), self.unit))
        return Patches(tuple(patches), faces, near)


def splinepy_patches(file: Path) -> tuple[list[GivenPatch], Faces]:
    """Read the patches of a file of splinepy, in its unit; it names no faces."""
    data = json.loads(file.read_text("utf-8"))
    splines = []
    for one in data["SplineList"]:
        degrees, points, weights = one["degrees"], one["control_points"], one.get("weights")
        bezier = [[0.0] * (p + 1) + [1.0] * (p + 1) for p in degrees]
        if data["Base64Encoding"]:
            points = _unpacked(points).reshape(-1, int(one["dim"]))
            weights = None if weights is None else _unpacked(weights)
        knots = one.get("knot_vectors") or bezier
        splines.append(_spline(degrees, knots, np.asarray(points, dtype=float), weights))
    return splines, {}


def _unpacked(text: str) -> Floats:
    return np.frombuffer(base64.b64decode(text), dtype=np.float64)


def gismo_patches(file: Path) -> tuple[list[GivenPatch], Faces]:
    """Read the patches of a file of G+Smo, in its unit, and its named boundaries."""
    root = ElementTree.fromstring(file.read_text("utf-8"))
    splines: list[GivenPatch] = []
    place: dict[str | None, int] = {}
    for geometry in root.iter("Geometry"):
        place[geometry.get("id")] = len(splines)
        splines.append(_of_xml(geometry))
    faces: dict[str, tuple[Face, ...]] = {}
    for boundary in root.iter("boundary"):
        numbers = [int(each) for each in (boundary.text or "").split()]
        if name := boundary.get("name"):
            for patch, side in zip(numbers[::2], numbers[1::2], strict=True):
                end = place[str(patch)], (side - 1) // 2, (side - 1) % 2  # ends of parameters
                faces[name] = (*faces.get(name, ()), end)
    return splines, faces


def _of_xml(geometry: ElementTree.Element) -> GivenPatch:
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
    """Numbers of an element, in ASCII or base64."""
    text, form = element.text or "", element.get("format", "ASCII").lower()
    if form == "b64float64":
        return _unpacked(text.strip())
    if form != "ascii":
        raise ValueError(form)
    return np.array(text.split(), dtype=float)


def _spline(degrees: Any, knots: Any, points: Floats, weights: Any) -> GivenPatch:
    """A patch from points that run fastest along the first parameter; in the plane without z."""
    vectors = tuple(tuple(float(k) for k in vector) for vector in knots)
    shape = tuple(len(k) - p - 1 for k, p in zip(vectors, degrees, strict=True))
    dim = len(shape)
    if dim == 2 and points.shape[-1] == 3:
        flat = bool((points[..., 2] == 0).all())
        require(flat, "control_points", "z", "patches of the plane in z = 0")
        points = points[..., :2]
    net = points.reshape(*shape[::-1], points.shape[-1]).transpose(*range(dim)[::-1], dim)
    if weights is not None:
        weights = tuple(np.asarray(weights, dtype=float).reshape(shape[::-1]).T.tolist())
    return GivenPatch(tuple(map(int, degrees)), vectors, tuple(net.tolist()), weights)
