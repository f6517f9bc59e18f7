"""Matrices from files and scenes of them: formats, dense eigenvalues, and what is refused."""

import gzip
import struct
from functools import reduce

import numpy as np
import pytest
from matrix_files import dense, inside, pieces, scene, undamped, write
from scipy.io import mmwrite, savemat
from scipy.sparse import csr_array, diags_array, random_array, save_npz, tril

from cea.errors import InputError
from cea.petsc import MPI, PETSc
from scenes import SceneError, load_matrices, load_scene, read_matrix_scene, run_matrices
from scenes.matrices.reading import read_matrix
from scenes.running.matrices import AssembledMatrices
from scenes.spec.matrices import split_name

pytestmark = pytest.mark.usefixtures("files_read_here")

GOOD = csr_array(random_array((7, 7), density=0.4, rng=np.random.default_rng(3)))


def petsc(matrix, file):
    viewer = PETSc.Viewer().createBinary(str(file), "w", comm=MPI.COMM_SELF)
    rows = (matrix.indptr, matrix.indices, matrix.data)
    PETSc.Mat().createAIJ(matrix.shape, csr=rows, comm=MPI.COMM_SELF).view(viewer)
    viewer.destroy()


def aij(*numbers, values=(), kind="i"):
    """A matrix of PETSc: sizes, entries of each row, columns, then values."""
    head = struct.pack(f">{len(numbers) + 1}{kind}", 1211216, *map(int, numbers))
    return head + struct.pack(f">{len(values)}d", *values)


def petsc_of_long_integers(m, file):
    """As a PETSc with 64 bit indices writes it."""
    numbers = [*m.shape, m.nnz, *np.diff(m.indptr), *m.indices]
    file.write_bytes(aij(*numbers, values=m.data, kind="q"))


def compressed(matrix, file):
    mmwrite(file.with_suffix(""), matrix)
    file.write_bytes(gzip.compress(file.with_suffix("").read_bytes()))


WRITERS = {
    "a.mat": lambda m, f: savemat(f, {"A": m, "note": "text"}),
    "dense.mat": lambda m, f: savemat(f, {"A": m.toarray(), "s": {"x": 1}}, do_compression=True),
    "a.mtx": lambda m, f: mmwrite(f, m),
    "dense.mtx": lambda m, f: mmwrite(f, m.toarray()),
    "a.mtx.gz": compressed,
    "a.npz": lambda m, f: save_npz(f, m),
    "columns.npz": lambda m, f: save_npz(f, m.tocsc()),
    "a.petsc": petsc,
    "long.bin": petsc_of_long_integers,
    "dense.petsc": lambda m, f: f.write_bytes(aij(*m.shape, -1, values=m.toarray().ravel())),
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
    for variable in (None, "C"):
        with pytest.raises(InputError, match="K, M"):
            read_matrix(tmp_path / "a.mat", variable, field="files.M")


def market(form, *lines):
    return "\n".join([f"%%MatrixMarket matrix coordinate {form} general", *lines, ""]).encode()


BAD = {
    "none.mat": (None, "existing"),
    "empty.mat": (b"", "empty"),
    "text.mat": (b"no matrix at all" * 20, "whole .mat file"),
    "new.mat": (b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM" + b"\0" * 400, "v7.3"),
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
    "column.petsc": (aij(2, 2, 2, 1, 1, 0, 9, values=(1, 1)), "whole"),
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


def test_files_are_read_by_a_program_of_their_own(tmp_path, monkeypatch):
    """Indices outside of a compressed matrix would end this one."""
    monkeypatch.undo()
    WRITERS["a.mat"](GOOD, tmp_path / "a.mat")
    assert (read_matrix(tmp_path / "a.mat")[0] != GOOD).nnz == 0
    (tmp_path / "cut.mat").write_bytes(BAD["text.mat"][0])
    parts = {"indices": [0, 1 << 28], "indptr": [0, 1, 2], "data": [1.0, 1.0]}
    np.savez(tmp_path / "csr.npz", format=b"csr", shape=[2, 2], **parts)
    for name in ("cut.mat", "csr.npz"):
        with pytest.raises(InputError, match="whole"):
            read_matrix(tmp_path / name)


N = 6
MASS = csr_array(np.eye(N))
CHAIN = csr_array(1e6 * diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(N, N)))
CLOSED_FORM = 2e3 * np.sin(np.arange(1, N + 1) * np.pi / (2 * N + 2)) / (2 * np.pi)
"""Frequencies (Hz) of a chain of springs and masses, fixed at both ends."""
NODES = [40, 3, -2, 7, 5, 100]
"""Labels of Abaqus; negative ones are its internal nodes."""


def chain(folder, *, K=CHAIN, M=MASS, **fields):
    """A scene of the chain, or of other matrices in its place, in files."""
    for name, matrix in {"K": K, "M": M}.items():
        mmwrite(folder / f"{name}.mtx", csr_array(matrix), precision=17)
    return read_matrix_scene(undamped("M.mtx", "K.mtx", 400.0, data=str(folder), **fields))


def run_chain(scene):
    """The result of a scene of the chain, whose eigenvalues are the closed ones."""
    result = run_matrices(scene)
    np.testing.assert_allclose(result.eigenvalues, 2j * np.pi * CLOSED_FORM, rtol=1e-11)
    return result


def test_a_chain_without_damping_is_a_symmetric_linear_problem(tmp_path):
    result = run_chain(chain(tmp_path))
    assert result.verdict == "stable"
    assert result.modes.window.symmetric_count is not None
    assert {"damping", "unsymmetric solver", "pictures", "paraview"} <= set(result.skipped)
    assert not result.warnings


def lines(matrix, file, labelled):
    """A file of Abaqus, a line for each entry: labels of node and degree of freedom, or numbers."""
    whole = matrix.tocoo()
    text = "** made by another program\n"
    for i, j, x in zip(*whole.coords, whole.data, strict=True):
        place = f"{NODES[i]},1, {NODES[j]},1, " if labelled else f"{i + 1} {j + 1}"
        text += f"{place} {x:.15e}\n"
    file.write_text(text)
    return file


@pytest.mark.parametrize(("labelled", "stiffness"), [(True, tril(CHAIN)), (False, CHAIN)])
def test_files_of_abaqus(labelled, stiffness, tmp_path):
    """With labels, a matrix is symmetric whichever triangle is there."""
    M, K = lines(MASS, tmp_path / "M.mtx", labelled), lines(stiffness, tmp_path / "K.mtx", labelled)
    run_chain(read_matrix_scene(undamped(M, K, 400.0)))
    matrix, told = read_matrix(K)
    order = np.argsort(NODES) if labelled else np.arange(N)
    assert abs(matrix - CHAIN[order][:, order]).max() == 0
    assert told.tolist() == [[n, 1] for n in sorted(NODES)] if labelled else told is None


# Scenes of matrices.
@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write(tmp_path_factory.mktemp("matrices"), pieces())


def test_damped_gyroscopic_circulatory_modes_are_all_those_of_lapack(folder):
    result = run_matrices(read_matrix_scene(scene(folder)), left=True)
    true = inside(dense(pieces()))
    assert len(true) >= 8
    np.testing.assert_allclose(result.eigenvalues, true, rtol=1e-9)
    assert result.verdict == "unstable"
    assert (true.real > 1e-3).any()
    kinds = {name: piece.symmetry for name, piece in result.pieces.items()}
    assert kinds == dict.fromkeys("MDKQ", "symmetric") | {"G": "skew", "F": "general"}


def test_what_is_symmetric_to_rounding_is_taken_so_and_told(tmp_path):
    K = CHAIN.toarray()
    K[3, 4] *= 1 + 4e-16
    assert K[3, 4] != K[4, 3]
    result = run_chain(chain(tmp_path, K=K))
    assert result.pieces["K"].symmetry == "symmetric to rounding"
    assert result.modes.window.symmetric_count is not None


def test_files_lie_beside_the_scene_or_where_it_is_said(folder, tmp_path):
    lines = ['name = "c"', 'files = {M = "M.mtx", K = "K.npz"}', "mass = {M = 1}"]
    lines += ["stiffness = {K = 1}", 'analysis = {kind = "cea", max_frequency = 0.6}']
    for place in (folder, tmp_path):
        (place / "c.toml").write_text("\n".join(lines))
    expected = run_matrices(load_matrices(folder / "c.toml")).eigenvalues
    for changes in ({"data": folder}, {"overrides": [f"data={folder}"]}):
        found = run_matrices(load_matrices(tmp_path / "c.toml", **changes)).eigenvalues
        np.testing.assert_array_equal(found, expected)
    with pytest.raises(InputError, match=r"files\.M"):
        run_matrices(load_matrices(tmp_path / "c.toml"))
    with pytest.raises(SceneError, match="load_matrices"):
        load_scene(folder / "c.toml")


@pytest.mark.parametrize(
    ("path", "value", "field", "told"),
    [
        ("mass", {}, "mass", "at least one"),
        ("analysis", {"kind": "static"}, "analysis.kind", "'cea'"),
        ("mass.X", 1.0, "mass.X", "M, D, G, K, F, Q"),
        ("stiffness.Q", None, "files.Q", "named in a sum"),
        ("damping.G", "v/w", "damping.G", "not w"),
        ("damping.G", "__import__('os')", "damping.G", "is not among sin"),
        ("damping.G", "1/(v - 2)", "damping.G", "finite value"),
        ("parameters.v", "v0", "parameters.v", "not v0"),
        ("parameters.pi", 1.0, "parameters.pi", "a name"),
    ],
)
def test_wrong_scenes_are_refused_by_name(path, value, field, told):
    """With a field changed, or left out where the value is None."""
    data, (*above, name) = scene("nowhere"), path.split(".")
    section = reduce(dict.get, above, data)
    section[name] = value
    if value is None:
        del section[name]
    with pytest.raises(SceneError) as refused:
        read_matrix_scene(data)
    assert any(f.field == field and told in f.allowed for f in refused.value.faults)


@pytest.mark.parametrize(
    ("mass", "field", "told"),
    [
        (np.eye(N - 1), "files.K", "5 rows"),
        (np.diag([*np.ones(N - 1), 0.0]), "mass", "1 unknowns without mass"),
        (np.eye(N) + np.diag(2 * np.ones(N - 1), 1), "files.M", "symmetric"),
        (np.eye(N) + 2 * np.eye(N)[::-1], "mass", "3 eigenvalues"),
    ],
)
def test_matrices_that_make_no_problem_are_refused(mass, field, told, tmp_path):
    with pytest.raises(InputError) as refused:
        run_matrices(chain(tmp_path, M=mass))
    assert refused.value.field == field
    assert told in str(refused.value)


@pytest.mark.parametrize("role", ["damping", "stiffness"])
def test_a_triangle_without_a_diagonal_may_be_half_of_a_matrix(role, tmp_path):
    """Two oscillators of stiffness 4 and G = g [0 1; -1 0]: omega^2 +- g omega - 4 = 0."""
    for name, matrix in {"M": np.eye(2), "K": 4 * np.eye(2), "G": [[0, 0.6], [0, 0]]}.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(np.array(matrix)), precision=17)
    data = undamped("M.mtx", "K.mtx", 1.0, data=str(tmp_path))
    data["files"]["G"] = "G.mtx"
    data[role] = data.get(role, {}) | {"G": 1.0}
    with pytest.raises(InputError, match=r"upper triangle alone': both triangles; .* skew") as no:
        run_matrices(read_matrix_scene(data))
    assert no.value.field == "files.G"
    found = run_matrices(read_matrix_scene(data | {"symmetric": {"G": True}})).eigenvalues
    if role == "stiffness":
        np.testing.assert_allclose(found, 1j * np.sqrt([3.4, 4.6]), rtol=1e-9)
    mmwrite(tmp_path / "G.mtx", csr_array([[0, 0.6], [-0.6, 0]]), precision=17)
    if role == "damping":
        found = run_matrices(read_matrix_scene(data)).eigenvalues
        np.testing.assert_allclose(found, 1j * (np.sqrt(4.09) + np.array([-0.3, 0.3])), rtol=1e-9)


def test_thresholds_of_matrices_are_the_closed_ones(tmp_path):
    """Kappa = 4.5 +- sqrt(0.25 - v^2/100): modes of two oscillators coalesce at v = 5.

    With damping c a mode of stiffness a + i b grows beyond b = c sqrt(a).
    """
    matrices = {"M": np.eye(2), "K": np.diag([4.0, 5.0]), "F": np.array([[0.0, 1.0], [-1.0, 0.0]])}
    for name, matrix in matrices.items():
        mmwrite(tmp_path / f"{name}.mtx", csr_array(matrix), precision=17)
    data = undamped("M.mtx", "K.mtx", 1.0, data=str(tmp_path)) | {
        "files": {name: f"{name}.mtx" for name in matrices},
        "parameters": {"v": 1.0, "c": 0.0},
        "damping": {"M": "c"},
        "stiffness": {"K": 1.0, "F": "v/10"},
    }
    undamped_scene = read_matrix_scene(data)
    assembled = AssembledMatrices(undamped_scene)
    found = assembled.threshold("parameters.v", 1.0, 8.0)
    assert found.value == pytest.approx(5.0, rel=1e-9)
    assert found.frequency == pytest.approx(np.sqrt(4.5) / (2 * np.pi), rel=1e-6)

    damped = AssembledMatrices(undamped_scene.change("parameters.c", 0.1))
    v = pytest.approx(10 * np.sqrt(0.25 + 0.1**2 * 4.5), rel=1e-9)
    assert damped.threshold("parameters.v", 1.0, 8.0).value == v
    assert damped.threshold("parameters.v", 1.0, 8.0, frequency=0.3).value == v
    for parameter, low, high, field in (
        ("parameters.w", 1.0, 8.0, "parameters.w"),
        ("parameters.v", 1.0, 2.0, "flutter"),
        ("parameters.v", 8.0, 9.0, "flutter"),
    ):
        with pytest.raises((InputError, SceneError), match=field):
            assembled.threshold(parameter, low, high)
