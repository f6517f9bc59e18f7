"""Contact stiffness that varies by orders of magnitude: eigenvalues, compressed rows."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from cea.contact.compression import compressed
from cea.petsc import MPI
from comparisons.stability.dense import dense_eigenvalues
from scenes import run_modes
from scenes.spec.plain import plain_data
from scenes.spec.reading import load_scene


def scene(backend, contrast, form):
    fields = {"contacts.interface.p": f"where(x<1, 1.0, {contrast!r})"}
    fields |= {"contacts.interface.form": form, "analysis.max_frequency": 0.7}
    for body, elements in (("upper", [3, 1]), ("lower", [4, 1])):
        mesh = f"bodies.{body}.mesh"
        fields[f"{mesh}.fe"] = {"cell": "quadrilateral", "degree": 2, "elements": elements}
        fields[f"{mesh}.iga"] = {"degree": [2, 2], "elements": elements}
    return load_scene("blocks", [], backend).change(fields)


@pytest.mark.parametrize("contrast", [1e12, 1e15])
@pytest.mark.parametrize("form", ["penalty", "saddle"])
def test_eigenvalues_are_those_of_dense_matrices(backend, form, contrast):
    varied = scene(backend, contrast, form)
    found = -(run_modes(varied).eigenvalues ** 2)
    assert len(found) >= 6
    expected = -(dense_eigenvalues(plain_data(varied)) ** 2)
    distance = np.abs(found[:, None] - expected).min(axis=1)
    assert (distance / np.abs(found)).max() < 1e-9


def hats(x, cells):
    """Hat functions on equal cells at points of [0, 1]."""
    return np.maximum(0.0, 1 - np.abs(cells * x[:, None] - np.arange(cells + 1)))


@pytest.mark.parametrize("case", ["even", "soft half", "noise"])
def test_compressed_rows_keep_products_and_are_as_many_as_the_rank(case):
    """Of gaps between functions on meshes that do not match, slips of other functions.

    Half of the rows may be larger by 3e7, beside which the others keep their digits; or columns
    that are zero hold rounding, as where normals are along axes.
    """
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(size=700))
    left, right = hats(x, 40), -hats(x, 33)
    gap = np.hstack([left, right, np.zeros((700, 50))])
    slip = np.hstack([0.3 * left, np.zeros_like(right), hats(x, 49)])
    rank, touched = np.linalg.matrix_rank(gap), slice(None)
    if case == "noise":
        gap[:, 80:90] = 1e-14 * rng.normal(size=(700, 10))
    if case == "soft half":
        scale = np.sqrt(np.where(x < 0.52, 1.0, 1e15))[:, None]
        gap, slip, touched = scale * gap, scale * slip, np.r_[0:19, 41:57]
    rows = compressed(csr_array(gap), csr_array(slip), x[:, None], MPI.COMM_SELF)
    closure, reaction = (matrix.toarray() for matrix in rows)
    within = 1e-12 if case == "soft half" else 1e-13
    assert case == "soft half" or len(closure) == np.linalg.matrix_rank(closure) == rank
    for found, given in ((closure, gap), (reaction, slip)):
        expected = given[:, touched].T @ gap[:, touched]
        error = np.abs(found[:, touched].T @ closure[:, touched] - expected).max()
        assert error < within * np.abs(expected).max()
