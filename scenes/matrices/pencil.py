"""The pencil of a scene of matrices: files are read on rank 0 and distributed by rows."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Ints
from cea.eigen.mumps import inertia
from cea.eigen.pencil import Pencil, Term
from cea.errors import InputError
from cea.matrices import destroy, distributed, zeros
from cea.petsc import MPI, Mat, PETSc
from cea.ranks import local_rows, made_on_first
from scenes.matrices.reading import half_of, mirrored, parts_of, read_matrix
from scenes.spec.matrices import ROLES, MatrixScene

_ROUNDING = np.finfo(float).eps


@dataclass(frozen=True)
class Piece:
    """A matrix read from a file."""

    symmetry: str  # symmetric, symmetric to rounding, skew, or general
    asymmetry: float
    size: int
    entries: int  # nonzeros
    # summands of the matrix, each with whether it is exactly symmetric: PETSc AIJ, but scipy
    # matrices on rank 0 and None on other ranks before they are distributed
    parts: tuple[tuple[Any, bool], ...]

    def plain(self) -> dict[str, Any]:
        """Return its size, entries and symmetry as plain data."""
        counts = {"size": self.size, "entries": self.entries}
        return {**counts, "symmetry": self.symmetry, "asymmetry": self.asymmetry}


def read_pieces(scene: MatrixScene, comm: Any = MPI.COMM_WORLD) -> dict[str, Piece]:
    """Read and distribute the matrices of a scene; collective."""
    read = made_on_first(comm, lambda: _read(scene)) or {}
    bare = {n: replace(p, parts=tuple((None, own) for _, own in p.parts)) for n, p in read.items()}
    pieces = {}
    for name, piece in comm.bcast(bare).items():
        parts = read[name].parts if read else piece.parts
        shared = tuple((_shared_out(part, piece.size, comm), own) for part, own in parts)
        pieces[name] = replace(piece, parts=shared)
    return pieces


def _read(scene: MatrixScene) -> dict[str, Piece]:
    """Read all matrices, with their parts as scipy matrices."""
    read: dict[str, Piece] = {}
    first: tuple[str, int, Ints | None] | None = None
    for name in scene.files:
        file, variable = scene.file(name)
        matrix, labels = read_matrix(file, variable, field=f"files.{name}")
        size = matrix.shape[0]
        first = first or (name, size, labels)
        if size != first[1]:
            allowed = f"{first[1]} rows, like files.{first[0]}"
            raise InputError(f"files.{name}", f"{size} rows in {scene.files[name]}", allowed)
        if not np.array_equal(labels, first[2]):  # type: ignore[arg-type]  # None equals None
            allowed = f"rows of the same nodes and degrees of freedom as files.{first[0]}"
            raise InputError(f"files.{name}", scene.files[name], allowed)
        if half := half_of(matrix):
            matrix = _of_half(scene, name, matrix, half)
        symmetry, asymmetry, parts = parts_of(matrix)
        if name in scene.mass and not symmetry.startswith("symmetric"):
            value = f"{symmetry}, relative asymmetry {asymmetry:.1e} of entries"
            raise InputError(f"files.{name}", value, "symmetric, because it is part of the mass")
        entries = sum(part.nnz for part, _ in parts)
        read[name] = Piece(symmetry, asymmetry, size, entries, tuple(parts))
    return read


def _of_half(scene: MatrixScene, name: str, matrix: csr_array, half: str) -> csr_array:
    """Return the matrix of a file with one triangle, mirrored or not as the scene specifies."""
    symmetric = (scene.symmetric or {}).get(name)
    if symmetric is None:
        value = f"{scene.files[name]}: entries in its {half} alone"
        allowed = (
            f"both triangles; --symmetric (in a scene symmetric = {{ {name} = true }}) mirrors "
            f"the {half}, --no-symmetric ({name} = false) takes the matrix as it is"
        )
        raise InputError(f"files.{name}", value, allowed)
    return mirrored(matrix) if symmetric else matrix


def _shared_out(matrix: csr_array | None, size: int, comm: Any) -> Mat:
    """Distribute a square matrix of rank 0 as PETSc AIJ; collective."""
    first, last = local_rows(size, comm)
    ends = comm.gather((first, last))
    blocks = None if matrix is None else [matrix[a:b] for a, b in ends]
    return distributed(comm.scatter(blocks), (last - first, size), comm)


def matrix_pencil(scene: MatrixScene, pieces: Mapping[str, Piece]) -> Pencil:
    """Return the pencil of a scene, with a zero stiffness term if there is no symmetric one."""
    terms = [
        Term(role, matrix, coefficient, symmetric)
        for role in ROLES
        for name, coefficient in scene.sum(role).items()
        for matrix, symmetric in pieces[name].parts
    ]
    if not any(term.role == "stiffness" and term.symmetric for term in terms):
        some: Any = terms[0].matrix
        rows, columns = some.getSizes()
        terms.append(Term("stiffness", zeros(rows, columns, some.comm)))
    return Pencil(terms, scene.of_pencil())


def check_mass(mass: Any, names: str) -> None:
    """Raise an InputError if M is not positive definite, from the inertia of M - n u diag(M).

    The shift with n rows and unit roundoff u detects a singular M independently of the units of
    the unknowns.
    """
    allowed = "a mass that is positive definite: condense unknowns without mass"
    if mass is None:
        raise InputError("mass", f"{names}: zero", allowed)
    diagonal = mass.getDiagonal()
    comm = mass.comm.tompi4py()
    without = comm.allreduce(int((diagonal.array_r <= 0).sum()))
    if without:
        diagonal.destroy()
        raise InputError("mass", f"{names}: {without} unknowns without mass", allowed)
    shifted = mass.copy()
    diagonal.scale(-mass.getSize()[0] * _ROUNDING)
    shifted.setDiagonal(diagonal, addv=PETSc.InsertMode.ADD_VALUES)
    shifted.assemble()
    shifted.setOption(shifted.Option.SYMMETRIC, True)
    negative = sum(inertia(shifted))
    destroy(diagonal)
    if negative:
        value = f"{names}: {negative} eigenvalues that are zero or negative"
        raise InputError("mass", value, allowed)
