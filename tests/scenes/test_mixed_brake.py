"""A brake whose disc has wedges at its hub, beside hexahedra alone and beside CalculiX."""

import shutil
import subprocess

import decks
import numpy as np
import pytest
from bodies import lagrange_body
from mixed_brake import Brake, calculix, calculix_of_one_body, one_body, scene
from mpi import on_ranks

from comparisons.bench import ccx as peer
from scenes import run_modes
from scenes.building.body_meshes import body_mesh, used_surfaces
from scenes.export.decks.write import write_deck
from scenes.spec.reading import read_scene

COUNT = 20


def modes(folder, size, order, *, wedges, friction):
    file = folder / f"brake{size}{order}{wedges}.inp"
    file.write_text(Brake(size, order, wedges=wedges).deck())
    result = run_modes(read_scene(scene(file, friction=friction)))
    assert ("mixed elements" in result.skipped) == wedges
    return np.sort(result.modes.frequencies)[:COUNT], sum(
        verdict == "unstable" for verdict in result.modes.verdicts()
    )


@pytest.mark.parametrize("ranks", [2, 3])
def test_a_divided_body_is_the_same_on_any_number_of_ranks(ranks):
    alone, spread = (on_ranks(n, "mixed_brake.on_any_number_of_ranks") for n in (1, ranks))
    assert len(alone["re"]) > 2
    for part in ("re", "im"):
        np.testing.assert_allclose(spread[part], alone[part], rtol=0, atol=1e-6 * max(alone["im"]))


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, 2])
def test_wedges_at_the_hub_change_little_and_less_on_finer_meshes(tmp_path, order):
    apart = []
    for size in (0.008, 0.005):
        (mixed, unstable), (whole, expected) = (
            modes(tmp_path, size, order, wedges=wedges, friction=0.6) for wedges in (True, False)
        )
        assert len(mixed) == len(whole) == COUNT
        assert unstable == expected > 0
        apart.append(np.abs(mixed / whole - 1).max())
    assert apart[0] < 0.01
    assert apart[1] < apart[0] / 2


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.008, 0.005])
def test_a_bonded_brake_has_the_frequencies_of_calculix(tmp_path, size):
    if shutil.which("ccx") is None:
        pytest.skip("ccx is not installed")
    (tmp_path / "job.inp").write_text(calculix(Brake(size, 2, wedges=True, bonded=True), COUNT))
    subprocess.run(["ccx", "-i", "job"], cwd=tmp_path, capture_output=True, check=True)
    rows = [line.split() for line in (tmp_path / "job.dat").read_text().splitlines()]
    theirs = np.array([float(row[3]) for row in rows if len(row) == 5 and row[0].isdecimal()])
    ours, _ = modes(tmp_path, size, 2, wedges=True, friction=0.0)
    assert len(theirs) >= COUNT
    assert np.abs(ours / theirs[:COUNT] - 1).max() < 0.01


def own_frequencies(scene, quadrature=None):
    """Angular frequencies of this program; the mass by a rule of a degree, exactly by default."""
    bodies = {
        name: lagrange_body(
            name,
            body_mesh(name, spec, used_surfaces(scene, name)),
            degree=spec.fe_degree,
            material=spec.material,
            supports=[support.support() for support in spec.supports],
            mass_quadrature=quadrature,
        )
        for name, spec in scene.bodies.items()
    }
    return np.sort(run_modes(scene, bodies=bodies).eigenvalues.imag)[:COUNT]


def one_deck(folder, size):
    brake = Brake(size, 1, wedges=True, bonded=True)
    (folder / "mixed.inp").write_text(brake.deck())
    return brake, folder / "mixed.inp"


def test_calculix_finds_the_same_on_the_tetrahedra_of_a_divided_body(tmp_path):
    """Its C3D10 on the mesh that wedges and hexahedra are divided into; one rule of the mass."""
    decks.with_calculix()
    scene = one_body(one_deck(tmp_path, 0.02)[1])
    found = peer.run(write_deck(scene, tmp_path, COUNT + 4)[1]).eigenvalues.imag[:COUNT]
    assert found == pytest.approx(own_frequencies(scene, 2), rel=1e-10)


@pytest.mark.parametrize("size", [0.02, pytest.param(0.008, marks=pytest.mark.slow)])
def test_linear_elements_of_calculix_are_farther_from_the_truth(tmp_path, size):
    """On one solid of plane faces, C3D8I and C3D6 err by twice what tetrahedra of degree 2 do.

    So a linear deck differs from its body here, which has degree 2 by default, by the error of the
    linear elements. The truth is the same solid at degree 4, at degree 3 on the finer mesh.
    """
    decks.with_calculix()
    brake, file = one_deck(tmp_path, size)
    job = tmp_path / "linear.inp"
    job.write_text(calculix_of_one_body(brake, COUNT + 4))
    theirs = peer.run(job).eigenvalues.imag[:COUNT]
    truth = own_frequencies(one_body(file, 4 if size > 0.01 else 3))
    errors = [values / truth - 1 for values in (theirs, own_frequencies(one_body(file)))]
    linear, own = (np.abs(each).max() for each in errors)
    assert errors[1].min() > 0  # Rayleigh's quotient on a subspace
    assert linear > 2 * own
