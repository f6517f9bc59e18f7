"""Pieces of a pencil, as operators that are multiplied by blocks of vectors.

    K(t) = sum_j c_j(t) K_j,    M(t) = sum_j c_j(t) M_j,    D(t) = sum_j c_j(t) D_j

D holds damping and what rotation makes of it; modal damping stays a product of its factors.

Pieces that depend on the parameters in the same way are summed once. Contact forces that are
unknowns stay so (:mod:`cea.eigen.multipliers`). Those of sides that are tied are constraints,
J x = 0, of all vectors.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.eigen.blocks import image_of
from cea.eigen.multipliers import ForcesOfContact
from cea.eigen.mumps import Mumps
from cea.eigen.parameters import CONSTANT, Dependence
from cea.eigen.pencil import Pencil, Role
from cea.eigen.unformed import LowRank
from cea.errors import InputError
from cea.matrices import destroy, scaled_total
from cea.petsc import PETSc

Values = Mapping[str, float]
"""Values of all parameters of a pencil."""
Product = Callable[[Floats], Floats]
"""An operator times a block of vectors, the rows of this rank."""


@dataclass(frozen=True)
class Piece:
    """c(t) A of one role of a pencil, as products of A and A^T with blocks of columns."""

    role: Role
    coefficient: Dependence
    times: Product
    transposed: Product

    @property
    def symmetric(self) -> bool:
        """Whether A is symmetric."""
        return self.times is self.transposed


class Rectangle:
    """A PETSc AIJ matrix (forces x displacements) times blocks; ``rows`` are those of this rank."""

    def __init__(self, matrix: Any) -> None:
        self._matrix = matrix
        self._x, self._f = matrix.createVecRight(), matrix.createVecLeft()
        self.rows = int(matrix.getLocalSize()[0])

    def times(self, x: Floats) -> Floats:
        """A x."""
        return self._columns(self._matrix.mult, x, self._x, self._f)

    def transposed(self, f: Floats) -> Floats:
        """A^T f."""
        return self._columns(self._matrix.multTranspose, f, self._f, self._x)

    @staticmethod
    def _columns(product: Any, block: Floats, x: Any, y: Any) -> Floats:
        image = np.empty((y.getLocalSize(), block.shape[1]))
        for i, column in enumerate(block.T):
            x.array[:] = column
            product(x, y)
            image[:, i] = y.array_r
        return image


@dataclass(frozen=True, eq=False)
class ContactPiece:
    """A contact whose forces f are unknowns: (J - c_f R)^T f on the bodies, J x = c_c C^ f.

    J and R as ``closes`` and ``slides``, None without friction; C^ as ``compliance`` and
    factorised; c_c and c_f; ``rows`` are its forces among all of this rank.
    """

    closes: Rectangle
    slides: Rectangle | None
    compliance: Product
    inverse: Mumps
    inverse_stiffness: Dependence
    friction: Dependence
    rows: slice


class Pieces:
    """All pieces of a pencil whose ``free`` parameters vary; InputError when tied sides rub."""

    def __init__(self, pencil: Pencil, free: Iterable[str]) -> None:
        self._made: list[Any] = []
        self._fixed = pencil.values()
        self._free = frozenset(pencil.parameter(name).name for name in free)
        self.tied = check_pencil(pencil, self._free)
        self.all = (
            *self._of_terms(pencil),
            *self._of_low_rank(pencil),
            *self._of_circulatory(pencil),
        )
        self.contacts = tuple(self._of_forces(pencil))

    def of(self, role: str) -> list[Piece]:
        """Pieces of one role."""
        return [piece for piece in self.all if piece.role == role]

    def free(self) -> None:
        """Free what was made of the pieces of the pencil."""
        for each in self._made:
            each.free() if isinstance(each, Mumps) else destroy(each)
        self._made.clear()

    def _of_terms(self, pencil: Pencil) -> Iterator[Piece]:
        """Matrices, those that depend on the free parameters in the same way together."""
        groups: list[tuple[Any, list[tuple[float, Any]]]] = []
        for term in pencil.terms:
            varies = bool(term.coefficient.names & self._free)
            key = (term.role, term.symmetric, term.coefficient if varies else None)
            weight = 1.0 if varies else term.coefficient.at(self._fixed)
            if not weight:
                continue
            for known, parts in groups:
                if known == key:
                    parts.append((weight, term.matrix))
                    break
            else:
                groups.append((key, [(weight, term.matrix)]))
        for (role, symmetric, coefficient), parts in groups:
            matrix = self._kept(scaled_total(parts))
            times = _product(matrix)
            transposed = times
            if not symmetric:
                transposed = _product(self._kept(matrix.transpose(PETSc.Mat())))
            yield Piece(role, coefficient or CONSTANT, times, transposed)

    def _of_low_rank(self, pencil: Pencil) -> Iterator[Piece]:
        """Damping of modes one by one."""
        for term in pencil.low_rank:
            times = _low_rank_product(term.piece, pencil.comm)
            yield Piece("damping", term.coefficient, times, times)

    def _of_circulatory(self, pencil: Pencil) -> Iterator[Piece]:
        """What damping that rotates with a body makes of displacements."""
        for term in pencil.circulatory:
            transposed = partial(term.piece.times, transposed=True)
            yield Piece("stiffness", term.coefficient, term.piece.times, transposed)

    def _of_forces(self, pencil: Pencil) -> Iterator["ContactPiece"]:
        """Contacts whose forces are unknowns, but for those that are tied."""
        first = 0
        for forces in pencil.forces:
            last = first + forces.closure.getLocalSize()[0]
            if forces not in self.tied:
                yield ContactPiece(
                    closes=Rectangle(forces.closure),
                    slides=None if forces.slip is None else Rectangle(forces.slip),
                    compliance=_product(forces.compliance),
                    inverse=self._kept(Mumps(forces.compliance.copy(), symmetric=True)),
                    inverse_stiffness=forces.inverse_stiffness,
                    friction=forces.friction,
                    rows=slice(first, last),
                )
            first = last

    def _kept[T](self, made: T) -> T:
        self._made.append(made)
        return made


def check_pencil(pencil: Pencil, free: Iterable[str]) -> tuple[ForcesOfContact, ...]:
    """The contacts that tie their sides, for any values of the free parameters.

    Raises InputError when sides that are tied rub: their forces are not to be eliminated.
    """
    values, free = pencil.values(), frozenset(free)
    tied = tuple(
        forces
        for forces in pencil.forces
        if not forces.inverse_stiffness.names & free and forces.is_tied(values)
    )
    if any(forces.slip is not None for forces in tied):
        raise InputError("P", np.inf, "finite in a map of parameters, where there is friction")
    return tied


def _product(matrix: Any) -> Product:
    return lambda block: image_of(matrix, block)


def _low_rank_product(piece: LowRank, comm: Any) -> Product:
    def times(block: Floats) -> Floats:
        image = np.zeros_like(block)
        image[piece.rows] = piece.times(block, comm)
        return image

    return times
