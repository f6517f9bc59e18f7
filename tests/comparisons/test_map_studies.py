"""Maps of tens of thousands of unknowns, and next to thresholds, beside full solves."""

from itertools import product

import numpy as np
import pytest
from reduced_blocks import flutter_of_the_blocks
from reduced_cases import enrichment, errors_of_means, model_line, three_blocks_pencil

from cea.eigen.driver import EigenSolver
from cea.eigen.matching import assign
from cea.reduced.full_solves import first_threshold
from cea.reduced.greedy import Enrichment, largest_ratio
from cea.reduced.model import ReducedModel
from cea.reduced.spectrum import MARGIN
from cea.reduced.thresholds import thresholds_along
from comparisons.sweep.axes import read_axis
from comparisons.sweep.mapped import mapped

MESH = {
    "fe": (),
    "iga": (
        "bodies.disc.mesh.iga={degree=[2,2,2],elements=[20,100,2],"
        "through={r=[0.09,0.14],theta=[25.0,65.0]}}",
        "bodies.pad.mesh.iga={degree=[2,2,2],elements=[8,14,4]}",
    ),
}
"""Beside the meshes of the scene: about as many unknowns with NURBS as with hexahedra."""
RNG = np.random.default_rng(11)


@pytest.mark.slow
def test_twenty_random_values_of_a_large_map(backend):
    """Over mu and eight decades of P, off the values that the basis was made for."""
    bodies = [f"bodies.{name}.backend='{backend}'" for name in ("pad", "disc")]
    axes = [read_axis("mu=0:1:5"), read_axis("P=1e6:1e14:log:17")]
    scene = mapped("disc_pad", axes, [*bodies, *MESH[backend]], None)
    assert 20_000 < scene.pencil.terms[0].matrix.getSize()[0] < 50_000
    top = scene.max_frequency
    model = ReducedModel(scene.pencil, scene.box, top)
    built = Enrichment(model, scene.driver, top)
    assert built.cover([scene.point(each) for each in product(*(a.values for a in axes))]) == 0.0
    assert len(built.snapshots) <= 30
    tested = [each.tested for each in built.snapshots if each.tested is not None]
    assert max(tested, default=0.0) <= 1
    for mu, decade in zip(RNG.uniform(0, 1, 20), RNG.uniform(6, 14, 20), strict=True):
        point = scene.point((mu, 10**decade))
        modes, found = scene.driver.solve(MARGIN * top, point), built.at(point)
        assert errors_of_means(found, -(modes.eigenvalues**2)).max() < 1e-8
        assert largest_ratio(found, modes) <= 1
        window = found.window
        rows, columns = assign(np.abs(window.eigenvalues[:, None] - modes.eigenvalues))
        apart = np.abs(window.eigenvalues[rows] - modes.eigenvalues[columns])
        assert (apart <= window.uncertainties[rows] + modes.growth_uncertainties[columns]).all()
    model.free()
    scene.driver.free()


@pytest.mark.grid(quick=1)
def test_next_to_the_threshold_of_the_blocks_bounds_hold(backend):
    """Either side of coalescence, from 1e-2 down to 1e-8 in mu; the threshold itself to 1e-8."""
    driver, name, bracket, top = flutter_of_the_blocks(backend)
    expected = first_threshold(driver, name, *bracket, max_frequency=top)
    built = enrichment(driver.pencil, {name: bracket}, top)
    built.cover([{name: value} for value in np.linspace(*bracket, 5)])
    values = np.linspace(*bracket, 5).tolist()
    found = thresholds_along(model_line(built, name), values).thresholds[0]
    assert found.value == pytest.approx(expected.value, rel=1e-8)
    mean = -(expected.eigenvalue**2).real
    for distance, side in product((1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8), (-1, 1)):
        point = {name: expected.value + side * distance}
        modes, said = driver.solve(MARGIN * top, point), built.at(point)
        true = -(modes.eigenvalues**2)
        theirs = np.argsort(np.abs(true - mean))[:2]
        mine = np.argsort(np.abs(said.kappa - mean))[:2]
        speed = abs(expected.eigenvalue)
        doubt = (2 * speed * modes.growth_uncertainties[theirs]).max()
        bounds = said.certificate
        off = abs(said.kappa[mine].mean() - true[theirs].mean())
        assert off <= bounds.means[mine].max() + 1e-12 * speed**2
        assert off < 1e-8 * speed**2
        rows, columns = assign(np.abs(said.kappa[mine][:, None] - true[theirs]))
        apart = np.abs(said.kappa[mine][rows] - true[theirs][columns])
        assert (apart <= bounds.errors[mine][rows] + doubt).all()
        assert largest_ratio(said, modes) <= 1


@pytest.mark.slow
def test_two_contacts_each_with_its_friction_and_stiffness(backend):
    pencil = three_blocks_pencil(backend)
    names = ["contacts.interface.mu", "contacts.other.mu"]
    stiff = ["contacts.interface.P", "contacts.other.P"]
    box = dict.fromkeys(names, (0.0, 0.9)) | dict.fromkeys(stiff, (0.1, 1e4))
    built = enrichment(pencil, box, 0.6)
    values = product((0.0, 0.45, 0.9), (0.0, 0.45, 0.9), *[(0.1, 10.0, 1e4)] * 2)
    points = [dict(zip((*names, *stiff), each, strict=True)) for each in values]
    assert built.cover(points) <= built.tolerance
    full = EigenSolver(pencil)
    for _ in range(20):
        point = dict(zip(names, RNG.uniform(0, 0.9, 2), strict=True))
        point |= dict(zip(stiff, 10 ** RNG.uniform(-1, 4, 2), strict=True))
        modes = full.solve(MARGIN * 0.6, point)
        assert errors_of_means(built.at(point), -(modes.eigenvalues**2)).max() < 1e-8
        assert largest_ratio(built.at(point), modes) <= 1
