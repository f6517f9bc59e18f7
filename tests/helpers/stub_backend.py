"""The least backend: bilinear elements on a rectangle, dense matrices of one rank, in numpy alone.

All that a new backend has to implement for matrices, supports, loads and contact.
"""

import numpy as np
from scipy.sparse import csr_array

from cea.location import cross
from cea.matrices import distributed
from cea.petsc import MPI
from cea.supports.directions import Directions
from cea.supports.elimination import constrain
from cea.surface import Surface
from cea.surface_points import SurfaceCells, SurfaceCoordinates

GAUSS = np.array([-1, 1]) / np.sqrt(3) / 2 + 0.5


class StubSpace:
    """nx by ny bilinear elements on a rectangle from the origin."""

    dim, comm = 2, MPI.COMM_SELF

    def __init__(self, lengths, elements):
        nx, ny = elements
        x, y = (np.linspace(0, size, n + 1) for size, n in zip(lengths, elements, strict=True))
        self.nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2)
        number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
        corners = [number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]]
        cells = np.stack(corners, axis=2)
        self.cells = cells.reshape(-1, 4)
        self.sides = np.array(lengths) / elements
        self.ranges = np.array([0, len(self.nodes)])
        self.surfaces = {
            "bottom": StubSurface("bottom", number[:, 0], cells[:, 0], -1.0, self),
            "top": StubSurface("top", number[::-1, -1], cells[::-1, -1], 1.0, self),
        }

    def constrain(self, supports, field):
        """Directions held at nodes."""
        held = []
        for number, support in enumerate(supports):
            surface = self.surfaces[support.surface]
            x = self.nodes[surface.line]
            for direction in support.directions(x, np.tile(surface.normal_vector, (len(x), 1))):
                held.append(Directions.of(surface.line, direction, support=number))
        return constrain(len(self.nodes), Directions.joined(held, 2), field=field)

    def stiffness(self, elasticity):
        """Elastic stiffness of an isotropic solid."""
        lam, mu = elasticity.matrix[0, 1], elasticity.matrix[3, 3]

        def of_point(N, g):
            K = lam * np.einsum("ai,bj->aibj", g, g) + mu * np.einsum("aj,bi->aibj", g, g)
            return K + mu * np.einsum("ac,bc,ij->aibj", g, g, np.eye(2))

        return self._matrix(of_point)

    def mass(self, rho):
        """Consistent mass."""
        return self._matrix(lambda N, g: rho * np.einsum("a,b,ij->aibj", N, N, np.eye(2)))

    def geometric_stiffness(self, elasticity, displacement):
        """Not there."""
        raise NotImplementedError

    gyroscopic = convective = geometric_stiffness

    @property
    def dof_positions(self):
        """Nodes."""
        return self.nodes

    def _matrix(self, of_point):
        whole = np.zeros((len(self.nodes), 2, len(self.nodes), 2))
        weight = np.prod(self.sides) / 4
        for s in GAUSS:
            for t in GAUSS:
                N, slopes = bilinear(s, t)
                element = weight * of_point(N, slopes / self.sides)
                for cell in self.cells:
                    whole[np.ix_(cell, range(2), cell, range(2))] += element
        flat = whole.reshape(2 * len(self.nodes), -1)
        rows = csr_array((flat + flat.T) / 2)
        return distributed(rows, rows.shape, self.comm)


def bilinear(s, t):
    """Functions of the unit square and their derivatives, corners with x fastest."""
    N = np.array([(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t])
    along = [[t - 1, s - 1], [1 - t, -s], [-t, 1 - s], [t, s]]
    return N, np.array(along)


class StubSurface(Surface):
    """A horizontal side of the rectangle, its segments in the order of a line of nodes."""

    abscissa_kinds, abscissa_weights = ("nodes",), ("equal", "tributary")

    def __init__(self, name, line, inside, outward, space):
        super().__init__(name, len(space.nodes))
        self.line, self.inside, self.space = line, inside, space
        self.normal_vector = np.array([0.0, outward])
        self.x = space.nodes[line]

    @property
    def domains(self):
        """Unit intervals."""
        return np.zeros((len(self.line) - 1, 1)), np.ones((len(self.line) - 1, 1))

    def cells(self):
        """The segments."""
        ends = np.tile([[0.0], [1.0]], (len(self.line) - 1, 1, 1))
        return SurfaceCells(np.arange(len(ends)), ends, 1, True)

    @property
    def element_areas(self):
        """Lengths."""
        return np.linalg.norm(np.diff(self.x, axis=0), axis=1)

    def size(self, element):
        """Lengths of elements."""
        return self.element_areas[element]

    def tangents(self, element, xi):
        """Positions and edges."""
        edge = self.x[element + 1] - self.x[element]
        return self.x[element] + xi * edge, edge[:, :, None]

    def area_normals(self, at):
        """Positions, normals, lengths."""
        x, tangents = self.tangents(at.element, at.xi)
        normal = cross(tangents)
        area = np.linalg.norm(normal, axis=1)
        return x, normal / area[:, None], area

    @property
    def function_dofs(self):
        """Ends of segments."""
        return np.stack([self.line[:-1], self.line[1:]], axis=1).ravel()

    def function_points(self, kind):
        """The same in coordinates."""
        count = len(self.line) - 1
        return SurfaceCoordinates(
            np.repeat(np.arange(count), 2), np.tile([[0.0], [1.0]], (count, 1))
        )

    def values(self, at, columns, count):
        """Linear functions."""
        t = at.xi[:, 0]
        entries = np.stack([1 - t, t], axis=1).ravel()
        place = columns.reshape(-1, 2)[at.element].ravel()
        return csr_array((entries, place, np.arange(0, len(entries) + 1, 2)), shape=(len(t), count))

    def gradient(self, at):
        """Bilinear functions differentiated."""
        sides, nodes = self.space.sides, self.space.nodes
        rows = np.zeros((2, len(at), len(nodes)))
        positions, _ = self.tangents(at.element, at.xi)
        for number, (x, own) in enumerate(zip(positions, self.inside[at.element], strict=True)):
            s, t = (x - nodes[own[0]]) / sides
            rows[:, number, own] = (bilinear(s, t)[1] / sides).T
        return tuple(csr_array(part) for part in rows)

    def join_smoothly(self, at, pairs):
        """The line is straight."""
        return np.ones(len(pairs), dtype=bool)

    def shares(self):
        """Half a segment to each end."""
        halves = np.repeat(self.element_areas / 2, 2)
        return np.bincount(self.functions, weights=halves)
