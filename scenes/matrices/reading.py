"""Matrices read from files of other programs, and the pencil of a scene of matrices.

Files are those of MATLAB, Matrix Market, Abaqus, PETSc and scipy. A matrix read is a real square
sparse matrix of finite numbers, or an InputError. It is split into a symmetric and a remaining
part. Rank 0 reads the files and distributes the matrices by rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from cea.arrays import Ints
from cea.eigen.coefficients import Parameter
from cea.eigen.mumps import inertia
from cea.eigen.pencil import Pencil, Term
from cea.errors import InputError, require
from cea.matrices import destroy, distributed, zeros
from cea.petsc import MPI, Mat, PETSc
from cea.ranks import local_rows, made_on_first
from meshes.files.reading import arrays_of
from scenes.spec.matrices import ROLES, MatrixScene

_LARGEST_SIZE = 50_000_000
"""Largest number of rows; more indicates a broken header."""
_MOST_ENTRIES = 2**31 - 1
"""Largest number of entries, the limit of 32-bit indices."""
_PROGRAM = Path(__file__).with_name("formats.py")
_EPSILON = np.finfo(float).eps
_ROUNDING = 16 * _EPSILON
"""Relative difference of an entry and its mirror image below which it is treated as rounding."""

type Parts = list[tuple[csr_array, bool]]
"""Summands of a matrix, each with whether it is exactly symmetric."""


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
        allowed = f"{first[1]} rows, like files.{first[0]}"
        require(size == first[1], f"files.{name}", f"{size} rows in {scene.files[name]}", allowed)
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
        if not matrix.diagonal().any():
            allowed += "; a skew matrix has both triangles in the file"
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
    signed = [Parameter(path, value, signed=True) for path, value in scene.values.items()]
    return Pencil(terms, signed)


def check_mass(mass: Any, names: str) -> None:
    """Raise an InputError if M is not positive definite, from the inertia of M - n u diag(M).

    The shift with n rows and unit roundoff u detects a singular M independently of the units of
    the unknowns.
    """
    allowed = "a mass that is positive definite: condense unknowns without mass"
    require(mass is not None, "mass", f"{names}: zero", allowed)
    diagonal = mass.getDiagonal()
    comm = mass.comm.tompi4py()
    without = comm.allreduce(int((diagonal.array_r <= 0).sum()))
    if without:
        diagonal.destroy()
        raise InputError("mass", f"{names}: {without} unknowns without mass", allowed)
    shifted = mass.copy()
    diagonal.scale(-mass.getSize()[0] * _EPSILON)
    shifted.setDiagonal(diagonal, addv=PETSc.InsertMode.ADD_VALUES)
    shifted.assemble()
    shifted.setOption(shifted.Option.SYMMETRIC, True)
    negative = sum(inertia(shifted))
    destroy(diagonal)
    value = f"{names}: {negative} eigenvalues that are zero or negative"
    require(not negative, "mass", value, allowed)


def read_matrix(
    file: str | Path, variable: str | None = None, *, field: str = "file"
) -> tuple[csr_array, Ints | None]:
    """Read a matrix, and the node and degree of freedom of each row, (n, 2), if the file has them.

    ``.mat``: MATLAB, versions 5 to 7.2, its only matrix or the named variable. ``.mtx``,
    ``.mtx.gz``: Matrix Market, or Abaqus if there is no header. ``.npz``: a sparse matrix of scipy.
    Other extensions: PETSc's binary format with 32- or 64-bit indices. Duplicate entries are
    summed, entries are sorted, and zeros are removed. An InputError names ``field``.
    """
    path, shown = Path(file), f"{file}:{variable}" if variable else str(file)
    try:
        filled = path.is_file() and path.stat().st_size > 0
        require(filled, field, shown, "an existing file that is not empty")
        arrays = arrays_of(_PROGRAM, path)
        labels = arrays.pop("labels", None)
        names = sorted({entry.rpartition(" ")[0] for entry in arrays})
        if variable is None and len(names) != 1:
            told = ", ".join(names) or "none"
            raise InputError(field, shown, f"one matrix, or FILE:VARIABLE; the matrices are {told}")
        if variable is not None and variable not in names:
            told = ", ".join(filter(None, names)) or "none: only .mat files have variables"
            raise InputError(field, shown, f"a variable among {told}")
        matrix = _checked(arrays, names[0] if variable is None else variable)
    except InputError as error:
        raise InputError(field, shown, error.allowed) from None
    except MemoryError:
        raise InputError(field, shown, "a matrix that fits into memory") from None
    except OSError as error:
        raise InputError(field, shown, f"a file that can be read ({error.strerror})") from error
    if labels is not None and matrix.diagonal().any() and half_of(matrix):
        matrix = mirrored(matrix)
    return matrix, labels


def _checked(arrays: dict[str, Any], name: str) -> csr_array:
    """Return a matrix of the arrays; raise an InputError unless it is real, finite and nonzero."""
    data, row, col, shape = (arrays[f"{name} {part}"] for part in ("data", "row", "col", "shape"))
    rows, columns = (int(n) for n in shape)
    few, allowed = len(data) <= _MOST_ENTRIES, f"at most {_MOST_ENTRIES} entries, not {len(data)}"
    require(rows == columns, "file", name, f"a square matrix, not {rows} x {columns}")
    require(0 < rows <= _LARGEST_SIZE, "file", name, f"1 to {_LARGEST_SIZE} rows, not {rows}")
    require(data.dtype.kind in "biuf", "file", name, f"real numbers, not {data.dtype}")
    require(few, "file", name, allowed)
    matrix = csr_array(coo_array((data, (row, col)), shape=(rows, columns)), dtype=float)
    matrix.sum_duplicates()
    require(bool(np.isfinite(matrix.data).all()), "file", name, "finite numbers")
    matrix.eliminate_zeros()
    require(matrix.nnz > 0, "file", name, "a matrix with an entry that is not zero")
    return matrix


def half_of(matrix: csr_array) -> str | None:
    """Return which half of a symmetric matrix this may be: no off-diagonal entry is mirrored.

    Return None if one has, for a diagonal matrix, and for one with entries in both triangles and
    an empty diagonal, e.g. that of friction forces along one direction due to pressures along
    another.
    """
    rows, columns = matrix.tocoo().coords
    below, above = bool((rows > columns).any()), bool((rows < columns).any())
    if not (below or above):
        return None
    if below != above:
        return "lower triangle" if below else "upper triangle"
    if not matrix.diagonal().any():
        return None
    pattern = csr_array((matrix - diags_array(matrix.diagonal())) != 0)
    return None if pattern.multiply(pattern.T).count_nonzero() else "half of mirrored entries"


def mirrored(half: csr_array) -> csr_array:
    """Return the symmetric matrix with the given half."""
    return csr_array(half + half.T - diags_array(half.diagonal()))


def parts_of(matrix: csr_array) -> tuple[str, float, Parts]:
    """Return the symmetry of a square matrix, its asymmetry, and its summands.

    The symmetry is ``symmetric``, ``symmetric to rounding`` (the part is then the mean with the
    transpose), ``skew`` or ``general`` (the parts are then the entries that equal their mirror
    image and the others, unchanged). The asymmetry is the largest difference of an entry and its
    mirror image, relative to the larger of both, or to sqrt(abs(a_ii a_jj)) if that is larger; this
    does not depend on the scaling of unknowns.
    """
    transpose = matrix.T.tocsr()
    difference = csr_array(matrix - transpose)
    difference.eliminate_zeros()
    if not difference.nnz:
        return "symmetric", 0.0, [(matrix, True)]
    rows, columns = difference.tocoo().coords
    root = np.sqrt(np.abs(matrix.diagonal()))
    larger = csr_array(abs(matrix)).maximum(csr_array(abs(transpose)))
    sizes = np.maximum(root[rows] * root[columns], np.asarray(larger[rows, columns]).ravel())
    worst = float((np.abs(difference.data) / sizes).max())
    if worst <= _ROUNDING:
        mean = csr_array(0.5 * matrix + 0.5 * transpose)
        return "symmetric to rounding", worst, [(mean, True)]
    rest = csr_array(matrix.multiply(difference != 0))
    equal = csr_array(matrix - rest)
    equal.eliminate_zeros()
    kind = "general" if (matrix + transpose).count_nonzero() else "skew"
    return kind, worst, [(part, part is equal) for part in (equal, rest) if part.nnz]
