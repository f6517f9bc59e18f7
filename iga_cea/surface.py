"""Named surfaces of NURBS bodies: points, location, trace and derivatives."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from math import prod
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import KDTree

from cea.arrays import Floats, Ints
from cea.corners import (
    TANGENT,
    connected,
    equal_shares,
    pairs_of_equal,
    smooth_parts,
    split_functions,
)
from cea.errors import InputError
from cea.location import locate_along
from cea.surface import Location, SurfaceCells, SurfaceCoordinates, SurfacePoints
from iga_cea.chart import FaceChart
from iga_cea.chunks import chunks
from iga_cea.face import PatchFace
from iga_cea.grids import grid_points
from iga_cea.kinks import smooth_pieces
from iga_cea.splines import gauss_rule

_AREA_POINTS = 12
"""Gauss points per span for the area: a quarter circle in one span needs ten for 1e-14."""

_TRIED_POINTS = (3, 4)
"""Gauss points per span that are enough, of fine spans, if they give the same area."""

_SAME_AREA = 1e-14
"""Difference of areas, relative to them, that is rounding."""

_ABSCISSAE = {"greville": attrgetter("greville"), "botella": attrgetter("botella")}
"""Abscissae of a face by kind."""

_SAME_POINT = 1e-8
"""Distance of points taken for one, relative to the mesh size."""


class NurbsSurface(FaceChart):
    """Faces of patches under one name; its elements are these faces, 0 to n - 1 in their order.

    A face with a kink is cut there, and counts as several.

    Parameters
    ----------
    name
        Name of the surface.
    faces
        Its faces, with global scalar dofs.
    num_scalar_dofs
        Scalar dofs of the body.
    """

    def __init__(self, name: str, faces: Sequence[PatchFace], num_scalar_dofs: int) -> None:
        super().__init__([piece for face in faces for piece in smooth_pieces(face)])
        self.name = name
        self.num_scalar_dofs = num_scalar_dofs

    @property
    def num_elements(self) -> int:
        """Number of its faces."""
        return len(self.faces)

    @cached_property
    def area(self) -> float:
        """Area (m^2; length in 2D), by Gauss quadrature, of no more points than it takes."""
        return float(self._face_areas.sum())

    @cached_property
    def _face_areas(self) -> Floats:
        few, more = (self._areas_by(n) for n in _TRIED_POINTS)
        same = abs(few.sum() - more.sum()) <= _SAME_AREA * more.sum()
        return more if same else self._areas_by(_AREA_POINTS)

    def _areas_by(self, n: int) -> Floats:
        """Areas of the faces by n points per span and direction, some spans at a time."""
        areas = np.zeros(len(self.faces))
        for number, face in enumerate(self.faces):
            if face.affine is not None:
                areas[number] = face.flat_area
                continue
            rules = [gauss_rule(breaks, n) for breaks in face.breaks]
            (t, weight), others = rules[0], [(x.ravel(), w.ravel()) for x, w in rules[1:]]
            per_span = n * prod(len(x) for x, _ in others)
            for part in chunks(len(t), 8 * per_span * 4 * self.dim**2):
                _, _, area = face.normals_on((t[part].ravel(), *(x for x, _ in others)))
                measure = grid_points((weight[part].ravel(), *(w for _, w in others)))
                areas[number] += float(measure.prod(axis=1) @ area)
        return areas

    @cached_property
    def mesh_size(self) -> float:
        """Diameter of its largest knot span (m)."""
        return max(face.size for face in self.faces)

    @property
    def abscissa_kinds(self) -> tuple[str, ...]:
        """Kinds of abscissae: Greville's, or the maxima of the B-splines."""
        return tuple(_ABSCISSAE)

    @property
    def abscissa_weights(self) -> tuple[str, ...]:
        """Kinds of weights of abscissae."""
        return ("equal", "area")

    @cached_property
    def dofs(self) -> Ints:
        """Scalar dofs with a value on the surface, rising."""
        return np.unique(np.concatenate([face.dofs[..., 0].ravel() for face in self.faces]))

    def cells(self) -> SurfaceCells:
        """Knot spans of all faces."""
        elements, corners = [], []
        for number, face in enumerate(self.faces):
            spans = [np.column_stack([breaks[:-1], breaks[1:]]) for breaks in face.breaks]
            index = np.indices([len(s) for s in spans]).reshape(len(spans), -1)
            ends = [s[i] for s, i in zip(spans, index, strict=True)]
            corners.append(
                ends[0][:, :, None]
                if len(ends) == 1
                else np.stack([ends[0][:, [0, 1, 1, 0]], ends[1][:, [0, 0, 1, 1]]], axis=2)
            )
            elements.append(np.full(index.shape[1], number))
        degree = max(max(face.degrees) for face in self.faces)
        return SurfaceCells(np.concatenate(elements), np.concatenate(corners), degree, True)

    def gauss_points(self, n: int) -> SurfacePoints:
        """Gauss points, n per direction in each knot span, weights with the Jacobian."""
        if n < 1:
            raise InputError("gauss_points", n, "at least one per direction")
        rules = [[gauss_rule(breaks, n) for breaks in face.breaks] for face in self.faces]
        at = _on_faces([tuple(x.ravel() for x, _ in rule) for rule in rules])
        reference = np.concatenate(
            [grid_points(tuple(w.ravel() for _, w in rule)).prod(axis=1) for rule in rules]
        )
        parts = [
            face.normals_on(tuple(x.ravel() for x, _ in rule))
            for face, rule in zip(self.faces, rules, strict=True)
        ]
        x, normal, area = (np.concatenate(each) for each in zip(*parts, strict=True))
        return SurfacePoints(at, x, normal, reference * area)

    def abscissae(self, kind: str, weights: str = "equal") -> SurfacePoints:
        """One point for each function of the split trace space, joined patches' points once.

        Parameters
        ----------
        kind
            ``greville``: tensor Greville abscissae. ``botella``: the maxima of the tensor
            B-splines; of the rational functions they are not quite the maxima.
        weights
            ``equal``: even shares of the area of each smooth part. ``area``: integrals of the split
            trace functions, which are positive and add up to the area (Matzen & Bischoff, A
            weighted point-based formulation for isogeometric contact, CMAME 308 (2016)).

        Raises
        ------
        InputError
            For another kind of abscissae or weights.
        """
        if kind not in self.abscissa_kinds:
            raise InputError("abscissae", kind, f"one of {', '.join(self.abscissa_kinds)}")
        if weights not in self.abscissa_weights:
            raise InputError("weights", weights, f"one of {', '.join(self.abscissa_weights)}")
        at = _on_faces([_ABSCISSAE[kind](face) for face in self.faces])
        # Each abscissa belongs to a control point, and joined control points are one function.
        functions = np.concatenate(self._functions)
        first = np.sort(np.unique(functions, return_index=True)[1])
        points = self._even(at[first])
        if weights == "equal":
            return points
        return replace(points, weight=self._shares[functions[first]])

    @cached_property
    def _shares(self) -> Floats:
        """Integrals over the surface of the split trace functions (m^2), (functions,)."""
        points = self.gauss_points(_AREA_POINTS)
        return np.asarray(self.split_trace(points.at).T @ points.weight)

    @cached_property
    def _functions(self) -> list[Ints]:
        """Numbers of the trace functions split at corners, of each face, flat."""
        dofs = [face.outer_dofs for face in self.faces]
        every, ends = np.concatenate(dofs), np.cumsum([len(part) for part in dofs])
        at = _on_faces([face.greville for face in self.faces])
        pairs = pairs_of_equal(every)
        groups = connected(pairs[self._join(at, pairs)], len(every))
        return np.split(split_functions(every, groups, self.num_scalar_dofs), ends[:-1])

    def _join(self, at: SurfaceCoordinates, pairs: Ints) -> NDArray[np.bool_]:
        """Whether faces join smoothly at pairs of points that lie at one place.

        A face is smooth: limits of its normal where an edge has collapsed are one.
        """
        one, other = pairs.T
        cosine = np.einsum("ij,ij->i", self.normal(at[one]), self.normal(at[other]))
        return (cosine >= TANGENT) | (at.element[one] == at.element[other])

    @cached_property
    def _parts(self) -> Ints:
        """Smooth part of each face, (faces,)."""
        element = np.repeat(np.arange(len(self.faces)), [len(part) for part in self._functions])
        return smooth_parts(element, np.concatenate(self._functions), len(self.faces))

    def grid(self, n: int) -> SurfacePoints:
        """Equally spaced parameters, n per direction over each face with its boundary.

        Points shared by joined faces count once in a smooth part, whose area is shared evenly among
        its points.
        """
        if n < 2:
            raise InputError("grid", n, "at least two points per direction")
        at = _on_faces(
            [tuple(np.linspace(k[0], k[-1], n) for k in face.knots) for face in self.faces]
        )
        pairs = KDTree(self.position(at)).query_pairs(
            _SAME_POINT * self.mesh_size, output_type="ndarray"
        )
        groups = connected(pairs[self._join(at, pairs)], len(at))
        return self._even(at[np.sort(np.unique(groups, return_index=True)[1])])

    def locate(self, x: Floats, direction: Floats, reach: float) -> Location:
        """Find points on the surface along unit directions, within ``reach`` (m) either way."""
        return locate_along(self, x, direction, reach)

    def position(self, at: SurfaceCoordinates) -> Floats:
        """Positions (m), shape (n, dim)."""
        return self.tangents(at.element, at.xi)[0]

    def normal(self, at: SurfaceCoordinates) -> Floats:
        """Outward unit normals, shape (n, dim)."""
        return self._normals(at)[1]

    def offset(self, at: SurfaceCoordinates, direction: Floats) -> Floats:
        """Zero: the surface is that of the shape, shape (n,)."""
        return np.zeros(len(at))

    def normal_error(self, at: SurfaceCoordinates) -> Floats:
        """Zero, shape (n, dim)."""
        return np.zeros((len(at), self.dim))

    def geometry_error(self, at: SurfaceCoordinates) -> Floats:
        """Zero, shape (n,)."""
        return np.zeros(len(at))

    def trace(self, at: SurfaceCoordinates) -> csr_array:
        """Values of the scalar basis functions, shape (n, num_scalar_dofs)."""
        return self._values(at, [face.outer_dofs for face in self.faces], self.num_scalar_dofs)

    def split_trace(self, at: SurfaceCoordinates) -> csr_array:
        """The same of the functions split at corners, shape (n, num_scalar_dofs + further)."""
        last = max(int(part.max()) for part in self._functions)
        return self._values(at, self._functions, max(self.num_scalar_dofs, last + 1))

    def _values(self, at: SurfaceCoordinates, numbers: Sequence[Ints], count: int) -> csr_array:
        """Values of the functions of all faces, in the columns of their numbers."""
        starts = self._starts(at, layers=1)
        columns, values = np.empty(starts[-1], dtype=np.int64), np.empty(starts[-1])
        for face, points in self.pieces(at.element):
            entries = starts[points][:, None] + np.arange(face.functions)
            functions, values[entries] = face.trace(at.xi[points])
            columns[entries] = numbers[at.element[points[0]]][functions]
        return self._operator(starts, columns, values, count)

    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Derivatives of the scalar basis functions along x, y, z, each (n, num_scalar_dofs)."""
        starts = self._starts(at, layers=2)
        columns, values = np.empty(starts[-1], dtype=np.int64), np.empty((self.dim, starts[-1]))
        for face, points in self.pieces(at.element):
            entries = starts[points][:, None] + np.arange(2 * face.functions)
            columns[entries], gradient = face.gradient(at.xi[points])
            values[:, entries] = np.moveaxis(gradient, 2, 0)
        count = self.num_scalar_dofs
        return tuple(self._operator(starts, columns, part, count) for part in values)

    def _starts(self, at: SurfaceCoordinates, layers: int) -> Ints:
        """Where the entries of each point begin, and where they end, (n + 1,)."""
        functions = np.array([layers * face.functions for face in self.faces])
        return np.concatenate([[0], np.cumsum(functions[at.element])])

    def _operator(self, starts: Ints, columns: Ints, values: Floats, count: int) -> csr_array:
        """Rows of points; where control points have collapsed to one their functions are added."""
        operator = csr_array((values, columns, starts), shape=(len(starts) - 1, count), copy=True)
        operator.sum_duplicates()  # in place, and other operators are made of the same arrays
        return operator

    def _normals(self, at: SurfaceCoordinates) -> tuple[Floats, Floats, Floats]:
        x, normal = np.empty((2, len(at), self.dim))
        area = np.empty(len(at))
        for face, rows in self.pieces(at.element):
            x[rows], normal[rows], area[rows] = face.normals(at.xi[rows])
        return x, normal, area

    def _even(self, at: SurfaceCoordinates) -> SurfacePoints:
        """Points that share the area of their smooth part evenly."""
        x, normal, _ = self._normals(at)
        areas = np.bincount(self._parts, weights=self._face_areas)
        weight = equal_shares(self._parts[at.element], areas, self.area)
        return SurfacePoints(at, x, normal, weight)


def _on_faces(parameters: Sequence[tuple[Floats, ...]]) -> SurfaceCoordinates:
    """Tensor grids, one on each face in order."""
    grids = [grid_points(p) for p in parameters]
    element = np.repeat(np.arange(len(grids)), [len(g) for g in grids])
    return SurfaceCoordinates(element, np.concatenate(grids))
