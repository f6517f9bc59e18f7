"""Matrices from files: each format as it was written, bad files refused, one triangle mirrored."""

import gzip
import struct

import numpy as np
import pytest
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, diags_array, random_array, save_npz, tril

from cea.errors import InputError
from cea.petsc import MPI, PETSc
from scenes.matrices.reading import read_matrix
from scenes.matrices.symmetry import equal_entries, symmetry_of
from scenes.running.matrices import run_matrices
from scenes.spec.matrices import read_matrix_scene, split_name

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
    "dense.mat": lambda m, f: savemat(f, {"A": m.toarray(), "s": {"x": 1}}, do_compression=True),
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
    found, labels = read_matrix(tmp_path / name)
    assert labels is None
    assert found.dtype == float
    assert found.has_canonical_format
    assert (found != GOOD).nnz == 0


def test_a_variable_is_named(tmp_path):
    savemat(tmp_path / "a.mat", {"K": GOOD, "M": 2 * GOOD})
    assert abs(read_matrix(tmp_path / "a.mat", "M")[0] - 2 * GOOD).max() == 0
    assert split_name("x/a.mat:M") == ("x/a.mat", "M")
    assert split_name("x:y/a.mtx") == ("x:y/a.mtx", None)
    for variable, told in ((None, "K, M"), ("C", "K, M")):
        with pytest.raises(InputError, match=told):
            read_matrix(tmp_path / "a.mat", variable, field="files.M")


def market(form, *lines):
    return "\n".join([f"%%MatrixMarket matrix coordinate {form} general", *lines, ""]).encode()


def aij(*numbers, values=()):
    """A matrix of PETSc: sizes, entries of each row, columns, then values."""
    head = struct.pack(f">{len(numbers) + 1}i", 1211216, *numbers)
    return head + struct.pack(f">{len(values)}d", *values)


BAD = {
    "none.mat": (None, "there"),
    "empty.mat": (b"", "empty"),
    "text.mat": (b"no matrix at all" * 20, "whole .mat file"),
    "new.mat": (b"MATLAB 7.3 MAT-file" + b"\0" * 500, "-v7"),
    "text.mtx": (b"1 2\n", "lines of 3 or 5 numbers"),
    "outside.mtx": (market("real", "2 2 1", "3 1 1.0"), "whole .mtx"),
    "oblong.mtx": (market("real", "2 3 1", "1 1 1.0"), "2 x 3"),
    "huge.mtx": (market("real", "999999999 999999999 1", "1 1 1.0"), "rows"),
    "complex.mtx": (market("complex", "1 1 1", "1 1 1.0 2.0"), "complex"),
    "nan.mtx": (market("real", "1 1 1", "1 1 nan"), "finite"),
    "zero.mtx": (market("real", "2 2 1", "1 1 0"), "not zero"),
    "cut.mtx.gz": (gzip.compress(market("real") * 50)[:40], "whole"),
    "text.npz": (b"PK\x03\x04 not really", "whole .npz"),
    "random.petsc": (bytes(range(256)), "a matrix of PETSc"),
    "cut.petsc": (aij(3, 3, 2, 1), "whole"),
    "rows.petsc": (aij(2, 2, 2, 1, 2, 0, 1, values=(1, 1)), "whole"),
    "column.petsc": (aij(2, 2, 2, 1, 1, 0, 9, values=(1, 1)), "whole"),
    "complex.petsc": (aij(2, 2, 2, 1, 1, 0, 1, values=(1, 0, 1, 0)), "complex"),
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


N = 6
MASS = csr_array(np.eye(N))
CHAIN = csr_array(1e6 * diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(N, N)))
CLOSED_FORM = 2e3 * np.sin(np.arange(1, N + 1) * np.pi / (2 * N + 2)) / (2 * np.pi)
"""Frequencies (Hz) of a chain of springs and masses, fixed at both ends."""


def scene(mass, stiffness, **fields):
    return {
        "name": "chain",
        "files": {"M": str(mass), "K": str(stiffness)},
        "mass": {"M": 1.0},
        "stiffness": {"K": 1.0},
        "analysis": {"kind": "cea", "max_frequency": 400.0},
        **fields,
    }


def frequencies(data):
    return np.sort(run_matrices(read_matrix_scene(data)).modes.eigenvalues.imag) / (2 * np.pi)


def labelled(matrix, file, nodes):
    """As MATRIX INPUT has it: node and degree of freedom of row and column, entry."""
    whole = matrix.tocoo()
    rows = zip(*whole.coords, whole.data, strict=True)
    lines = [f"{nodes[i]},1, {nodes[j]},1,  {x:.15e}\n" for i, j, x in rows]
    file.write_text("** made by another program\n" + "".join(lines))
    return file


def coordinates(matrix, file):
    whole = matrix.tocoo()
    rows = zip(*whole.coords, whole.data, strict=True)
    file.write_text("".join(f"{i + 1} {j + 1} {x:.15e}\n" for i, j, x in rows))
    return file


@pytest.fixture
def mass(tmp_path):
    save_npz(tmp_path / "M.npz", MASS)
    return tmp_path / "M.npz"


@pytest.mark.parametrize("lower", [True, False])
def test_one_triangle_is_refused_until_it_is_said_what_it_is(tmp_path, mass, lower):
    triangle = csr_array(tril(CHAIN)) if lower else csr_array(tril(CHAIN).T)
    save_npz(tmp_path / "K.npz", triangle)
    name = "lower" if lower else "upper"
    with pytest.raises(InputError, match=f"--symmetric .*mirrors the {name} triangle") as refused:
        frequencies(scene(mass, tmp_path / "K.npz"))
    assert refused.value.field == "files.K"
    assert f"entries in its {name} triangle alone" in str(refused.value)
    found = frequencies(scene(mass, tmp_path / "K.npz", symmetric={"K": True}))
    np.testing.assert_allclose(found, CLOSED_FORM, rtol=1e-9)


def test_files_of_abaqus_with_labels(tmp_path):
    nodes = [40, 3, -2, 7, 5, 100]  # negative ones are internal nodes of Abaqus
    M = labelled(MASS, tmp_path / "job_MASS1.mtx", nodes)
    K = labelled(csr_array(tril(CHAIN)), tmp_path / "job_STIF1.mtx", nodes)
    np.testing.assert_allclose(frequencies(scene(M, K)), CLOSED_FORM, rtol=1e-9)
    matrix, labels = read_matrix(K)
    order = np.argsort(nodes)
    assert labels.tolist() == [[n, 1] for n in sorted(nodes)]
    assert abs(matrix - CHAIN[order][:, order]).max() == 0


def test_files_of_abaqus_with_coordinates(tmp_path):
    M, K = coordinates(MASS, tmp_path / "M.mtx"), coordinates(CHAIN, tmp_path / "K.mtx")
    np.testing.assert_allclose(frequencies(scene(M, K)), CLOSED_FORM, rtol=1e-9)
