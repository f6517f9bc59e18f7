"""Named surfaces of NURBS bodies: faces of patches, their traces and derivatives."""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Floats, Ints, chunks
from cea.surface import Surface
from cea.surface_points import TANGENT, SurfaceCells, SurfaceCoordinates
from iga_cea.face import PatchFace
from iga_cea.kinks import smooth_pieces

_AREA_POINTS = 12
"""Gauss points per span for the area: a quarter circle in one span needs ten for 1e-14."""


class NurbsSurface(Surface):
    """Named faces of patches; its elements are these faces, numbered from 0 in their order.

    A face with kinks is divided there into several elements.
    """

    abscissa_kinds = ("greville", "botella")
    abscissa_weights = ("equal", "area")

    def __init__(self, name: str, faces: Sequence[PatchFace], num_scalar_dofs: int) -> None:
        super().__init__(name, num_scalar_dofs)
        self.faces = tuple(piece for face in faces for piece in smooth_pieces(face))

    @cached_property
    def domains(self) -> tuple[Floats, Floats]:
        """Lower and upper ends of the parameters of each face, both (faces, dim - 1)."""
        ends = np.array([[knots[[0, -1]] for knots in face.knots] for face in self.faces])
        return ends[:, :, 0], ends[:, :, 1]

    @cached_property
    def cells(self) -> SurfaceCells:
        """The knot spans of all faces."""
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

    @cached_property
    def element_areas(self) -> Floats:
        """Area (m^2; length in 2D) of each face."""
        points = self.gauss_points(_AREA_POINTS)
        faces = range(len(self.faces))
        return np.array([points.weight[points.at.element == number].sum() for number in faces])

    @cached_property
    def sizes(self) -> Floats:
        """Diameter (m) of the largest knot span of each face."""
        return np.array([face.size for face in self.faces])

    def tangents(self, element: Ints, xi: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, dim) and derivatives dx_i/dxi_j (n, dim, dim - 1)."""
        x = np.empty((len(element), self.dim))
        derivatives = np.empty((len(element), self.dim, self.dim - 1))
        for face, rows in self._pieces(element):
            x[rows], derivatives[rows] = face.tangents(xi[rows])
        return x, derivatives

    def area_normals(self, at: SurfaceCoordinates) -> tuple[Floats, Floats, Floats]:
        """Return positions, unit normals, area per area of xi; limits on collapsed edges."""
        x, normal = np.empty((2, len(at), self.dim))
        area = np.empty(len(at))
        for face, rows in self._pieces(at.element):
            x[rows], normal[rows], area[rows] = face.normals(at.xi[rows])
        return x, normal, area

    def _pieces(self, element: Ints) -> Iterator[tuple[PatchFace, Ints]]:
        """Yield each face with the rows of its points, in chunks."""
        for number, face in enumerate(self.faces):
            rows = np.flatnonzero(element == number)
            for part in chunks(len(rows), 8 * 2 * face.functions * (3 * self.dim + 2)):
                yield face, rows[part]

    @cached_property
    def function_dofs(self) -> Ints:
        """Scalar dofs of the control points of each face, face by face."""
        return np.concatenate([face.outer_dofs for face in self.faces])

    def function_points(self, kind: str) -> SurfaceCoordinates:
        """Return tensor Greville abscissae (``greville``) or B-spline maxima (``botella``).

        The latter are only approximately the maxima of the rational functions.
        """
        grids = [face.abscissae(kind) for face in self.faces]
        element = np.repeat(np.arange(len(grids)), [len(grid) for grid in grids])
        return SurfaceCoordinates(element, np.concatenate(grids))

    def values(self, at: SurfaceCoordinates, columns: Ints, count: int) -> csr_array:
        """Return values of face functions; those of coinciding control points are summed."""
        starts = self._starts(at, layers=1)
        places, values = np.empty(starts[-1], dtype=np.int64), np.empty(starts[-1])
        before = np.cumsum([0, *(len(face.outer_dofs) for face in self.faces)])
        for face, points in self._pieces(at.element):
            entries = starts[points][:, None] + np.arange(face.functions)
            functions, values[entries] = face.trace(at.xi[points])
            places[entries] = columns[before[at.element[points[0]]] + functions]
        return self._operator(starts, places, values, count)

    def gradient(self, at: SurfaceCoordinates) -> tuple[csr_array, ...]:
        """Return derivatives of the scalar basis along x, y, z, each (n, num_scalar_dofs)."""
        starts = self._starts(at, layers=2)
        columns, values = np.empty(starts[-1], dtype=np.int64), np.empty((self.dim, starts[-1]))
        for face, points in self._pieces(at.element):
            entries = starts[points][:, None] + np.arange(2 * face.functions)
            columns[entries], gradient = face.gradient(at.xi[points])
            values[:, entries] = np.moveaxis(gradient, 2, 0)
        count = self.num_scalar_dofs
        return tuple(self._operator(starts, columns, part, count) for part in values)

    def _starts(self, at: SurfaceCoordinates, layers: int) -> Ints:
        """Return the row pointers of the points, (n + 1,)."""
        functions = np.array([layers * face.functions for face in self.faces])
        return np.concatenate([[0], np.cumsum(functions[at.element])])

    def _operator(self, starts: Ints, columns: Ints, values: Floats, count: int) -> csr_array:
        """Return the rows of points; functions of coinciding control points are summed."""
        operator = csr_array((values, columns, starts), shape=(len(starts) - 1, count), copy=True)
        operator.sum_duplicates()  # in place, on a copy: other operators use the same arrays
        return operator

    def join_smoothly(self, at: SurfaceCoordinates, pairs: Ints) -> NDArray[np.bool_]:
        """Return whether faces join smoothly at pairs of coincident points.

        A face is smooth: its normal at a collapsed edge is a unique limit.
        """
        one, other = pairs.T
        cosine = np.einsum("ij,ij->i", self.normal(at[one]), self.normal(at[other]))
        return (cosine >= TANGENT) | (at.element[one] == at.element[other])

    def shares(self) -> Floats:
        """Return integrals of the split trace functions, which are positive (m^2), (functions,).

        Matzen & Bischoff, A weighted point-based formulation for isogeometric contact, CMAME 308
        (2016).
        """
        points = self.gauss_points(_AREA_POINTS)
        return np.asarray(self.split_trace(points.at).T @ points.weight)
