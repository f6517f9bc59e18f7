"""Matrices from files: each format as it was written, and bad files refused by name."""

import gzip
import struct

import numpy as np
import pytest
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, random_array, save_npz

from cea.errors import InputError
from cea.petsc import MPI, PETSc
from scenes.matrices.reading import read_matrix
from scenes.matrices.symmetry import equal_entries, symmetry_of
from scenes.spec.matrices import split_name

RNG = np.random.default_rng(0)
GOOD = csr_array(random_array((7, 7), density=0.4, rng=np.random.default_rng(3)))


def petsc(matrix, file):
    viewer = PETSc.Viewer().createBinary(str(file), "w", comm=MPI.COMM_SELF)
    A = PETSc.Mat().createAIJ(
        matrix.shape, csr=(matrix.indptr, matrix.indices, matrix.data), comm=MPI.COMM_SELF
    )
    A.view(viewer)
    viewer.destroy()


def petsc_of_long_integers(matrix, file, values=None):
    """As a PETSc with 64 bit indices writes it."""
    values = matrix.data if values is None else values
    numbers = [1211216, *matrix.shape, matrix.nnz, *np.diff(matrix.indptr), *matrix.indices]
    content = struct.pack(f">{len(numbers)}q", *(int(n) for n in numbers))
    file.write_bytes(content + np.asarray(values).astype(values.dtype.newbyteorder(">")).tobytes())


def petsc_dense(matrix, file):
    content = struct.pack(">4i", 1211216, *matrix.shape, -1)
    file.write_bytes(content + matrix.toarray().astype(">f8").tobytes())


def text_compressed(matrix, file):
    plain = file.with_suffix("")
    mmwrite(plain, matrix)
    file.write_bytes(gzip.compress(plain.read_bytes()))


WRITERS = {
    "a.mat": lambda m, f: savemat(f, {"A": m, "note": "text"}),
    "dense.mat": lambda m, f: savemat(f, {"A": m.toarray()}, do_compression=True),
    "whole_numbers.mat": lambda m, f: savemat(f, {"A": m.toarray(), "s": {"x": 1}, "c": "text"}),
    "a.mtx": lambda m, f: mmwrite(f, m),
    "dense.mtx": lambda m, f: mmwrite(f, m.toarray()),
    "a.mtx.gz": text_compressed,
    "a.npz": lambda m, f: save_npz(f, m),
    "columns.npz": lambda m, f: save_npz(f, m.tocsc()),
    "a.petsc": petsc,
    "long.bin": petsc_of_long_integers,
    "dense.petsc": petsc_dense,
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_what_was_written(name, tmp_path):
    WRITERS[name](GOOD, tmp_path / name)
    found = read_matrix(tmp_path / name)
    assert found.dtype == float
    assert found.has_canonical_format
    assert (found != GOOD).nnz == 0


def test_a_variable_is_named(tmp_path):
    savemat(tmp_path / "a.mat", {"K": GOOD, "M": 2 * GOOD})
    assert abs(read_matrix(tmp_path / "a.mat", "M") - 2 * GOOD).max() == 0
    assert split_name("x/a.mat:M") == ("x/a.mat", "M")
    assert split_name("x:y/a.mtx") == ("x:y/a.mtx", None)
    for variable, told in ((None, "K, M"), ("C", "K, M")):
        with pytest.raises(InputError, match=told):
            read_matrix(tmp_path / "a.mat", variable, field="files.M")


BAD = {
    "none.mat": (None, "there is none"),
    "empty.mat": (b"", "empty"),
    "text.mat": (b"no matrix at all" * 20, "whole MATLAB file"),
    "new.mat": (b"MATLAB 7.3 MAT-file" + b"\0" * 500, "-v7"),
    "hdf.mat": (b"\x89HDF\r\n\x1a\n" + b"\0" * 500, "-v7"),
    "text.mtx": (b"1 2\n", "whole Matrix Market"),
    "cut.mtx": (
        b"%%MatrixMarket matrix coordinate real general\n3 3 3\n1 1 1.0\n",
        "whole Matrix",
    ),
    "outside.mtx": (
        b"%%MatrixMarket matrix coordinate real general\n2 2 1\n3 1 1.0\n",
        "whole Matrix",
    ),
    "oblong.mtx": (b"%%MatrixMarket matrix coordinate real general\n2 3 1\n1 1 1.0\n", "2 x 3"),
    "huge.mtx": (
        b"%%MatrixMarket matrix coordinate real general\n999999999 999999999 1\n1 1 1.0\n",
        "rows",
    ),
    "complex.mtx": (
        b"%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1.0 2.0\n",
        "complex",
    ),
    "pattern.mtx": (
        b"%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n",
        "pattern",
    ),
    "nan.mtx": (b"%%MatrixMarket matrix coordinate real general\n1 1 1\n1 1 nan\n", "finite"),
    "zero.mtx": (b"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 0\n", "not zero"),
    "nothing.mtx": (b"%%MatrixMarket matrix coordinate real general\n2 2 0\n", "not zero"),
    "none_at_all.mtx": (b"%%MatrixMarket matrix coordinate real general\n0 0 0\n", "rows"),
    "cut.mtx.gz": (gzip.compress(b"%%MatrixMarket matrix " * 50)[:40], "whole"),
    "text.npz": (b"PK\x03\x04 not really", "whole scipy"),
    "random.petsc": (bytes(range(256)), "a matrix of PETSc"),
    "short.petsc": (b"\0\x12", "a matrix of PETSc"),
    "cut.petsc": (struct.pack(">5i", 1211216, 3, 3, 2, 1), "end is missing"),
    "negative.petsc": (struct.pack(">4i", 1211216, -3, -3, 2), "rows"),
    "rows.petsc": (
        struct.pack(">8i", 1211216, 2, 2, 2, 1, 2, 0, 1) + struct.pack(">2d", 1, 1),
        "rows and entries disagree",
    ),
    "column.petsc": (
        struct.pack(">8i", 1211216, 2, 2, 2, 1, 1, 0, 9) + struct.pack(">2d", 1, 1),
        "whole",
    ),
    "longer.petsc": (
        struct.pack(">8i", 1211216, 2, 2, 2, 1, 1, 0, 1) + struct.pack(">3d", 1, 1, 1),
        "24 bytes for 2 numbers",
    ),
    "complex.petsc": (
        struct.pack(">8i", 1211216, 2, 2, 2, 1, 1, 0, 1) + struct.pack(">4d", 1, 0, 1, 0),
        "complex",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_refused_by_name(name, tmp_path):
    content, told = BAD[name]
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as refused:
        read_matrix(tmp_path / name, field="files.K")
    assert refused.value.field == "files.K"
    assert refused.value.value == str(tmp_path / name)
    assert told in refused.value.allowed


def test_indices_outside_of_a_compressed_matrix_are_refused(tmp_path):
    for form in (b"csr", b"csc"):
        parts = {"indices": [0, 1 << 28], "indptr": [0, 1, 2], "data": [1.0, 1.0]}
        np.savez(tmp_path / "a.npz", format=form, shape=[2, 2], **parts)
        with pytest.raises(InputError, match="whole"):
            read_matrix(tmp_path / "a.npz")


def test_parts_of_a_matrix_keep_every_bit():
    A = random_array((40, 40), density=0.3, rng=RNG).toarray() ** 7
    A[:20, :20] += A[:20, :20].T
    A[20:, 20:] += np.diag(np.ones(20))
    equal, rest = equal_entries(csr_array(A))
    assert symmetry_of(equal).kind == "symmetric"
    assert equal.nnz > 20
    assert ((equal + rest).toarray() == A).all()
    assert not equal.multiply(rest).nnz
