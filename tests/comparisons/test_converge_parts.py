"""Errors in parts, one for each body and direction: measured, predicted, made use of."""

from dataclasses import replace
from math import inf, log, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest
from exact_scenes import ExactScene

from cea.eigen.eigenvalue_matching import assign
from comparisons.converge.aims import may_remain, wanted
from comparisons.converge.bars import Usual, bar, observed_rate
from comparisons.converge.following import Cluster, Sequence
from comparisons.converge.histories import Window, history_of
from comparisons.converge.judged import Judged
from comparisons.converge.leanest import Wanted, leanest
from comparisons.converge.levels import Estimates, estimate, given_elements, run_level
from comparisons.converge.parts import Part, Parts, positions_of, taken_off
from comparisons.converge.probes import measured, probes, seconds_of_probes
from comparisons.converge.quantities import Member
from comparisons.converge.request import Request
from comparisons.kit.progress import Progress
from meshes.shapes import Hub
from scenes.memory import estimated_memory
from scenes.read import load_scene
from scenes.refinement import BodyResolution, Resolution, counted, mixed, refined
from scenes.spec.support import SupportSpec

SILENT = Progress(step=lambda _: None, stage=lambda _: None)
PARTS = (Part("disc", (1,)), Part("disc", (0, 2), edges=True), Part("pad", (0,)))


def resolution(disc=(1.0, 1.0, 1.0), pad=(1.0, 1.0, 1.0), degree=3, layers=0):
    """A mesh of disc and pad."""
    return mixed(
        {"disc": BodyResolution(degree, disc, layers), "pad": BodyResolution(degree, pad, 0)}
    )


def parts_of(errors):
    """Parts of one mode with given relative errors of lambda, as if measured on a mesh."""
    values = np.array([1j])
    corrected = np.array([[1j * (1 - e)] for e in errors])
    ones = np.ones(len(errors))
    strained = np.ones((len(errors), 1))
    return Parts(PARTS, ones, values, corrected, strained, np.array([True]), False, resolution(), 0)


def errors_at(parts, mesh):
    """Parts of the first mode on a mesh."""
    first = np.array([0])
    own = parts.of_mean(first)
    return parts.at(mesh, own[None], parts.local(own, first)[None])[0]


# How parts fall


def test_a_part_falls_with_its_own_direction_alone():
    parts = parts_of([1e-3, 0.0, 1e-4])
    before = errors_at(parts, resolution())
    assert before == pytest.approx([1e-3, 0.0, 1e-4], rel=1e-2)
    theta = errors_at(parts, resolution(disc=(1.0, 2.0, 1.0)))
    assert theta / np.maximum(before, 1e-99) == pytest.approx([2.0**-6, 0.0, 1.0])
    pad = errors_at(parts, resolution(pad=(2.0, 1.0, 1.0)))
    assert pad[[0, 2]] / before[[0, 2]] == pytest.approx([1.0, 2.0**-6])


def test_a_degree_raises_every_smooth_part_of_its_body_to_a_power():
    parts = parts_of([1e-3, 0.0, 1e-4])
    before = errors_at(parts, resolution())
    after = errors_at(parts, resolution(degree=4))
    assert after[[0, 2]] == pytest.approx(before[[0, 2]] ** (4 / 3), rel=1e-9)
    back = replace(parts, resolution=resolution(degree=4))
    assert errors_at(back, resolution())[[0, 2]] == pytest.approx(before[[0, 2]] ** 0.75, rel=1e-9)


def test_what_a_degree_does_for_a_body_does_not_hang_on_its_share_of_a_mode():
    """A tenth of the strain energy of a mode with a tenth of the error falls by the same factor."""
    whole = parts_of([1e-3, 0.0, 1e-4])
    little = replace(whole, strained=np.array([[1.0], [1.0], [0.1]]))
    factors = []
    for parts in (whole, little):
        after = errors_at(parts, resolution(degree=4))
        factors.append(after[[0, 2]] / errors_at(parts, resolution())[[0, 2]])
    assert factors[0] == pytest.approx([1e-3 ** (1 / 3), 1e-4 ** (1 / 3)], rel=1e-2)
    assert factors[1] == pytest.approx(np.full(2, 1e-3 ** (1 / 3)), rel=1e-2)
    unresolved = replace(whole, strained=np.array([[1.0], [1.0], [1e-6]]))
    after = errors_at(unresolved, resolution(degree=4))[2]
    assert after / 1e-4 == pytest.approx(0.1 ** (1 / 3), rel=1e-2)
    finer = resolution(pad=(2.0, 1.0, 1.0))
    assert errors_at(little, finer)[2] == pytest.approx(1e-4 * 2.0**-6, rel=1e-2)


def test_edges_fall_with_layers_and_with_the_coarser_of_their_directions():
    parts = parts_of([0.0, 1e-3, 0.0])
    whole = errors_at(parts, resolution())[1]
    assert errors_at(parts, resolution(layers=1))[1] / whole == pytest.approx(0.2**1.2)
    assert errors_at(parts, resolution(disc=(2.0, 9.0, 1.0)))[1] == pytest.approx(whole)
    both = errors_at(parts, resolution(disc=(2.0, 1.0, 2.0)))[1]
    assert both / whole == pytest.approx(2.0**-1.2)


def test_re_entrant_edges_fall_slower_than_clamped_ones():
    clamped = parts_of([0.0, 1e-3, 0.0])
    re_entrant = replace(clamped, parts=(PARTS[0], replace(PARTS[1], exponent=0.5445), PARTS[2]))
    whole = errors_at(re_entrant, resolution())[1]
    finer = resolution(disc=(2.0, 1.0, 2.0))
    assert errors_at(re_entrant, resolution(layers=2))[1] / whole == pytest.approx(0.2**2.178)
    assert errors_at(re_entrant, finer)[1] / whole == pytest.approx(2.0**-1.089)
    both = replace(re_entrant, corrected=np.array([[0.998j], [0.999j], [1j]]))
    both = replace(both, parts=(Part("disc", (0,)), *both.parts[1:]))
    assert both.of_mean(np.array([0]))[0] == pytest.approx(
        2e-3 - (1 - 2.0**-1.089) * 1e-3, rel=1e-2
    )


def test_a_degree_of_lagrange_elements_does_twice_as_much_at_edges():
    splines = parts_of([0.0, 1e-3, 0.0])
    lagrange = replace(splines, parts=(PARTS[0], replace(PARTS[1], of_degree=2.0), PARTS[2]))
    for parts, power in ((splines, 1.2), (lagrange, 2.4)):
        before, after = errors_at(parts, resolution())[1], errors_at(parts, resolution(degree=4))[1]
        assert after / before == pytest.approx(0.75**power)


def test_what_finer_elements_take_off_of_edges_is_no_smooth_part():
    found = replace(parts_of([1e-3, 1e-3, 5e-4]), parts=(Part("disc", (0,)), *PARTS[1:]))
    of_mean = found.of_mean(np.array([0]))
    assert of_mean[0] == pytest.approx(1e-3 - (1 - 2.0**-1.2) * 1e-3, rel=1e-2)
    assert of_mean[2] == pytest.approx(5e-4, rel=1e-2)  # another body's
    edges_alone = replace(found, corrected=np.array([[0.9995j], [0.998j], [1j]]))
    assert edges_alone.of_mean(np.array([0]))[0] == pytest.approx(0.1 * 5e-4, rel=1e-2)


def test_positions_rise_with_what_is_taken_off():
    own = np.array([1e-2, 1e-5])
    fallen = np.array([own, own / 30, own / 900])
    assert positions_of(fallen, own) == pytest.approx([0.0, log(30), log(900)])
    flat = positions_of(np.zeros((3, 2)), np.zeros(2))
    assert np.all(np.diff(flat) > 0)


def test_a_step_is_trusted_little_more_than_the_part_that_falls_least():
    """Of parts that matter: which of them leads on the finer mesh is not known for sure."""
    own = np.array([[1e-2, 1e-3, 1e-5]])
    assert taken_off(own, own / np.array([1000.0, 2.0, 1.0]), own)[0] == pytest.approx(log(10.0))
    assert taken_off(own, own / np.array([1000.0, 1.0, 1.0]), own)[0] == pytest.approx(log(5.0))
    even = np.array([[1e-2, 1e-2, 1e-5]])
    half = even / np.array([1e6, 20.0, 1.0])
    assert taken_off(even, half, even)[0] == pytest.approx(log(even.sum() / half.sum()), rel=1e-3)


# Measured


@pytest.mark.grid
@pytest.mark.parametrize("name", ["blocks", "drum"])
def test_the_sum_of_the_parts_is_the_error(backend, name):
    """Against exact eigenvalues, mode by mode, on a mesh of another density for each direction."""
    scene = load_scene(name)
    degree = {"iga": 3, "fe": 2}[backend]
    level = run_level(scene, backend, counted(scene, backend, Resolution(degree, 0.8)), SILENT)
    parts = measured(level, 0, scene, SILENT)
    assert len(parts.parts) == 4
    exact = ExactScene(name).exact()
    values = level.eigenvalues
    rows, columns = assign(np.abs(values[:, None] - exact) / np.abs(exact))
    squares, true = values[rows] ** 2, exact[columns] ** 2
    alone = np.abs(squares - true) < 0.02 * np.abs(true)
    errors = (0.5 * np.abs(squares - true) / np.abs(true))[alone]
    sums = np.array([parts.of_mean(np.array([i])).sum() for i in rows[alone]])
    ratio = sums / errors
    assert 0.9 < np.median(ratio) < 1.3
    assert (ratio > 0.7).all()


def test_what_is_predicted_of_another_mesh_is_its_error(backend):
    """Measured on one mesh, the errors of one that is finer in two directions are told."""
    scene, exact = load_scene("blocks"), ExactScene("blocks").exact()
    degree = {"iga": 3, "fe": 2}[backend]
    first = counted(scene, backend, Resolution(degree, 0.8))
    level = run_level(scene, backend, first, SILENT)
    parts = measured(level, 0, scene, SILENT)
    bodies = dict(first.bodies)
    n = bodies["upper"].densities
    bodies["upper"] = replace(bodies["upper"], densities=(1.5 * n[0], 2 * n[1]))
    finer = counted(scene, backend, mixed(bodies))
    values = run_level(scene, backend, finer, SILENT).eigenvalues
    real = np.flatnonzero(values.real == 0)[:6]
    found = []
    for value in values[real]:
        i = np.abs(level.eigenvalues - value).argmin()
        true = np.abs(exact - value).min() / abs(value)
        alone = np.array([i])
        own = parts.of_mean(alone)
        found.append(parts.fallen(own, parts.local(own, alone), [finer]).sum() / true)
    assert 0.5 < np.median(found) < 2


def test_probes_are_of_every_body_and_direction_and_of_edges():
    scene = load_scene("disc_pad")
    mesh = counted(scene, "iga", Resolution(3, 0.5))
    found = [
        (probe.part.body, probe.part.directions, probe.part.edges)
        for probe in probes(scene, "iga", mesh)
    ]
    assert found == [
        *(("pad", (d,), False) for d in range(3)),
        ("pad", (0, 1, 2), True),
        *(("disc", (d,), False) for d in range(3)),
        ("disc", (0, 2), True),
    ]
    assert seconds_of_probes(scene, "iga", mesh) > 0


THIN = (
    "bodies.disc.mesh.fe={cell='hexahedron',degree=2,elements=[6,16,2],"
    "through={r=[0.09,0.14],theta=[25.0,65.0]}}",
    "bodies.pad.mesh.fe={cell='hexahedron',degree=2,elements=[4,4,2]}",
    "analysis.max_frequency=3000.0",
)


@pytest.mark.slow
def test_what_a_thin_disc_owes_across_is_not_laid_to_its_edges():
    """A layer at the edges divides no cell elsewhere, and takes off of little that is smooth."""
    scene, shares = load_scene("disc_pad", list(THIN)), []
    for degree in (2, 3):
        level = run_level(scene, "fe", counted(scene, "fe", Resolution(degree, 0.5)), SILENT)
        parts = measured(level, 0, scene, SILENT)
        thin = next(i for i, each in enumerate(parts.parts) if each.body == "disc" and each.edges)
        shares.append(parts.of_mean(None)[thin])
    probe = probes(scene, "fe", parts.resolution)[thin]
    assert probe.part == parts.parts[thin]
    assert probe.beside is None
    assert shares[1] < shares[0] < 4 * shares[1]


def test_probes_know_the_exponents_of_their_edges():
    """Stresses at a re-entrant edge of a right angle are of the power of Williams."""
    scene = load_scene("disc_pad")
    on_hub = Hub(0.03, 0.06, 0.14, 0.0, 0.01, -0.02, 0.01)
    disc = replace(scene.bodies["disc"], geometry=on_hub, supports=(SupportSpec("bore"),))
    with_hub = replace(scene, bodies={**scene.bodies, "disc": disc})
    exponents = []
    for each in (scene, with_hub):
        found = probes(each, "iga", counted(each, "iga", Resolution(2, 0.5)))
        exponents.append({p.part.body: p.part.exponent for p in found if p.part.edges})
    assert exponents[0] == {"pad": 0.6, "disc": 0.6}
    williams = exponents[1].pop("disc")
    assert exponents[1] == {"pad": 0.6}
    assert abs(sin(1.5 * pi * williams) - williams) < 1e-3
    assert 0.5 < williams < 0.6


def test_a_layer_through_a_thin_body_is_laid_beside_twice_the_elements():
    """It divides the one element across everywhere, and so takes off of what is smooth."""
    scene = load_scene("disc_pad", ["bodies.disc.mesh.iga.elements=[6,24,1]"])
    mesh = counted(scene, "iga", Resolution(2, 1.0))
    last = probes(scene, "iga", mesh)[-1]
    assert (last.part.body, last.part.edges) == ("disc", True)
    assert dict(last.beside.bodies)["disc"].densities == (1.0, 1.0, 2.0)


def test_unstructured_bodies_are_probed_as_a_whole():
    scene = load_scene("ventilated_brake")
    found = probes(scene, "fe", counted(scene, "fe", Resolution(2, 0.5)))
    assert [probe.part.body for probe in found] == list(scene.bodies)
    for probe in found:
        assert dict(probe.resolution.bodies)[probe.part.body].degree == 3
    highest = probes(scene, "fe", counted(scene, "fe", Resolution(4, 0.5)))
    for probe in highest:
        assert dict(probe.resolution.bodies)[probe.part.body].densities[0] == 1.0


# The cheapest mesh


def leanest_of(errors, gain, most_seconds=1e9):
    """The cheapest mesh that takes a factor off the error of one mode, with its elements."""
    scene = load_scene("disc_pad")
    first = counted(scene, "iga", Resolution(3, 0.5))
    parts = replace(parts_of(errors), resolution=first)
    own = parts.of_mean(np.array([0]))[None, :]
    wanted = Wanted(own, own, np.array([log(gain)]), first, 1.0)
    step = leanest(
        parts,
        "iga",
        first,
        given_elements(scene, "iga"),
        wanted,
        lambda mesh: estimate(scene, "iga", mesh),
        most_seconds,
    )
    return first, parts, step, own


def test_the_direction_that_owes_most_is_refined():
    first, parts, step, own = leanest_of([1e-3, 1e-6, 1e-6], 20.0)
    assert step.enough
    before, after = dict(first.bodies), dict(step.resolution.bodies)
    assert after["pad"] == before["pad"]
    assert after["disc"].densities[0] == before["disc"].densities[0]
    assert after["disc"].layers == 0
    assert parts.at(step.resolution, own, own).sum() * 20 <= own.sum() * (1 + 1e-9)


def test_layers_are_laid_where_edges_owe_most():
    _, _, step, _ = leanest_of([1e-6, 1e-3, 1e-6], 20.0)
    assert step.enough
    assert dict(step.resolution.bodies)["disc"].layers >= 1
    assert dict(step.resolution.bodies)["pad"].layers == 0


def test_a_mesh_that_time_does_not_allow_is_as_near_as_it_does():
    first = counted(load_scene("disc_pad"), "iga", Resolution(3, 0.5))
    time = estimate(load_scene("disc_pad"), "iga", first)
    _, _, step, _ = leanest_of([1e-3, 1e-6, 1e-6], 1e4, most_seconds=1.6 * time)
    assert not step.enough
    assert step.seconds <= 1.6 * time
    assert leanest_of([1e-3, 1e-6, 1e-6], 1e4, most_seconds=time)[2] is None


def test_modes_that_are_right_already_ask_for_no_finer_mesh():
    """Of two modes the one with an error far below that allowed may keep it."""
    scene, first = (
        load_scene("disc_pad"),
        counted(load_scene("disc_pad"), "iga", Resolution(3, 0.5)),
    )
    values = np.array([1e4j, 2e4j])
    errors = np.array([[1e-3, 1e-9], [1e-9, 1e-9], [1e-9, 1e-7]])
    corrected, strained = values * (1 - errors), np.ones((3, 2))
    known = np.full(2, True)
    parts = Parts(PARTS, np.ones(3), values, corrected, strained, known, False, first, 0)
    level = SimpleNamespace(eigenvalues=values, resolution=first, uncertainties=np.zeros(2))
    sequence = Sequence("iga", True, [level], parts=parts)
    clusters = tuple(Cluster((np.array([i]),), False) for i in range(2))
    members = tuple(Member(v, inf, inf, "undecided", None, 1) for v in values)
    judged = Judged(members, clusters, Window())
    aim = wanted(judged, sequence, Request("disc_pad"), scene, 1.0, spare=0.0)
    assert aim.gains[0] == pytest.approx(log(4 * 1e-3 / 5e-4) + log(1.5), rel=1e-2)
    assert aim.gains[1] == 0.0
    easy = wanted(judged, sequence, Request("disc_pad", digits=1), scene, 1.0, spare=0.0)
    assert easy.gains == pytest.approx(log(2.0))  # of what is right already a mesh more is seen


def test_every_part_is_to_fall_by_half_from_the_newest_mesh_and_not_from_its_correction():
    """What a correction takes off is no mesh, and is not asked for once more beyond it."""
    scene = load_scene("disc_pad")
    meshes = [counted(scene, "iga", Resolution(3, density)) for density in (0.5, 1.0)]
    bodies = dict(meshes[1].bodies)
    n, halved = bodies["disc"].densities, log(2.0)
    bodies["disc"] = replace(bodies["disc"], densities=(n[0], 1.2 * n[1], n[2]), layers=1)
    corrected_to = mixed(bodies)
    value, errors = np.array([1e4j]), np.array([[1e-3], [1e-4], [1e-5]])
    parts = Parts(
        PARTS,
        np.ones(3),
        value,
        value * (1 - errors),
        np.ones((3, 1)),
        np.full(1, True),
        False,
        meshes[0],
        0,
    )
    levels = [
        SimpleNamespace(eigenvalues=value, resolution=mesh, uncertainties=np.zeros(1))
        for mesh in meshes
    ]
    link = [(np.array([0]), np.array([0]))]
    sequence = Sequence("iga", True, levels, links=[link], parts=parts)
    richer = SimpleNamespace(eigenvalues=value, resolution=corrected_to)
    whole = replace(sequence, correction=richer)
    members = (Member(value[0], 1.0, inf, "stable", None, 3),)
    judged = Judged(members, (Cluster((np.array([0]),) * 2, False),), Window())
    gains = [
        wanted(judged, each, Request("disc_pad"), scene, 1.0, spare=0.0, everywhere=True).gains[-3:]
        for each in (sequence, whole)
    ]
    assert gains[0] == pytest.approx(halved)
    own = np.diag(parts.of_mean(np.array([0])))
    fallen = [parts.at(mesh, own, own).diagonal() for mesh in (meshes[1], corrected_to)]
    assert gains[1] == pytest.approx(halved - np.log(fallen[0] / fallen[1]))
    assert (gains[1][:2] < 0).all()  # more than that is taken off by now
    assert gains[1][2] == pytest.approx(halved)  # of the pad nothing is


def test_digits_of_growth_ask_for_what_takes_off_of_the_splitting():
    """Of a pair whose mean is right the splitting is not: its growth owes all to one part."""
    scene, first = (
        load_scene("disc_pad"),
        counted(load_scene("disc_pad"), "iga", Resolution(3, 0.5)),
    )
    omega, growth, wrong = 1e4, 100.0, 0.02
    values = np.array([growth + 1j * omega, -growth + 1j * omega])
    corrected = np.array([values, (1 - wrong) * values.real + 1j * values.imag, values])
    strained, known = np.ones((3, 2)), np.full(2, True)
    parts = Parts(PARTS, np.ones(3), values, corrected, strained, known, False, first, 0)
    level = SimpleNamespace(eigenvalues=values, resolution=first, uncertainties=np.zeros(2))
    sequence = Sequence("iga", True, [level], parts=parts)
    cluster = Cluster((np.arange(2),), False)
    members = tuple(
        Member(v, inf, inf, verdict, None, 1)
        for v, verdict in zip(values, ("unstable", "stable"), strict=True)
    )
    judged = Judged(members, (cluster,), Window())
    aim = wanted(judged, sequence, Request("disc_pad"), scene, 1.0, spare=0.0)
    assert len(aim.gains) == 3  # the two members, and what grows
    assert aim.errors[2] == pytest.approx([0.0, wrong, 0.0], rel=0.02, abs=1e-9)
    assert aim.gains[2] == pytest.approx(log(4 * wrong / 5e-3) + log(1.5), rel=1e-2)
    assert aim.gains[:2].max() < aim.gains[2]


def test_growth_that_is_not_held_is_planned_by_the_splitting_on_later_meshes_too():
    """By its bar, which is known then; the mean, whose own bar holds, is not asked for it."""
    scene = load_scene("disc_pad")
    meshes = [counted(scene, "iga", Resolution(3, density)) for density in (0.5, 0.7, 1.0)]
    growth, wrong, need = 100.0, 0.02, 7.0
    values = np.array([growth + 1e4j, -growth + 1e4j])
    corrected = np.array([values, (1 - wrong) * values.real + 1j * values.imag, values])
    strained, known = np.ones((3, 2)), np.full(2, True)
    parts = Parts(PARTS, np.ones(3), values, corrected, strained, known, False, meshes[0], 0)
    levels = [
        SimpleNamespace(eigenvalues=values, resolution=mesh, uncertainties=np.zeros(2))
        for mesh in meshes
    ]
    link = [(np.arange(2), np.arange(2))]
    sequence = Sequence("iga", True, levels, links=[link, link], parts=parts)
    request = Request("disc_pad")
    bars = 1e-3 * request.tolerance * 1e4, need * request.growth_tolerance * growth
    members = tuple(
        Member(v, *bars, verdict, 1.0, 3)
        for v, verdict in zip(values, ("unstable", "stable"), strict=True)
    )
    judged = Judged(members, (Cluster((np.arange(2),) * 3, False),), Window())
    aim = wanted(judged, sequence, request, scene, 1.0, spare=0.0)
    assert aim.errors[2] == pytest.approx([0.0, wrong, 0.0], rel=0.02, abs=1e-9)
    assert aim.gains[2] == pytest.approx(log(need) + log(1.5))
    assert aim.gains[:2] == pytest.approx(0.0)


@pytest.mark.parametrize("apart", [4e6, 1e4])
def test_frequencies_of_a_pair_ask_for_what_parts_them(apart):
    """Of one that does not flutter: what its bar has of the splitting, near or far from zero."""
    scene, first = (
        load_scene("disc_pad"),
        counted(load_scene("disc_pad"), "iga", Resolution(3, 0.5)),
    )
    values = np.sqrt(np.array([-1e8 + apart, -1e8 - apart], complex))
    error = 0.02 * apart**2
    moved = np.sqrt(np.array([-1e8, -1e8]) + np.sqrt(apart**2 + error) * np.array([1, -1]) + 0j)
    corrected = np.array([values, moved, values])
    strained, known = np.ones((3, 2)), np.full(2, True)
    parts = Parts(PARTS, np.ones(3), values, corrected, strained, known, False, first, 0)
    level = SimpleNamespace(eigenvalues=values, resolution=first, uncertainties=np.zeros(2))
    sequence = Sequence("iga", True, [level], parts=parts)
    members = tuple(Member(v, 1.0, 0.0, "stable", None, 2) for v in values)
    judged = Judged(members, (Cluster((np.arange(2),), False),), Window())
    request = Request("disc_pad")
    aim = wanted(judged, sequence, request, scene, 1.0, spare=0.0)
    assert len(aim.gains) == 3  # the two members, and what parts them
    may = np.exp(log(4) + log(1.5) - aim.gains[2]) * error if aim.gains[2] > 0 else inf
    root = apart - np.sqrt(apart**2 - may) if may < apart**2 else np.sqrt(apart**2 + may)
    assert may == inf or root == pytest.approx(2e8 * request.tolerance, rel=0.05)
    assert (aim.gains[2] > 0) == (apart > 1e6)


def test_growth_of_a_pair_that_met_later_is_planned_by_what_is_usual():
    """It was no pair where parts were measured; its splitting is taken to err as others' means."""
    scene = load_scene("disc_pad")
    meshes = [counted(scene, "iga", Resolution(3, density)) for density in (0.5, 1.0)]
    alone, wrong = np.array([1e4j, 1.1e4j]), 1e-3
    corrected = np.array([(1 - wrong) * alone, alone, alone])
    strained, known = np.ones((3, 2)), np.full(2, True)
    parts = Parts(PARTS, np.ones(3), alone, corrected, strained, known, False, meshes[0], 0)
    met = np.array([100.0 + 1e4j, -100.0 + 1e4j])
    levels = [
        SimpleNamespace(eigenvalues=values, resolution=mesh, uncertainties=np.zeros(2))
        for values, mesh in zip((alone, met), meshes, strict=True)
    ]
    each = [(np.arange(2), np.arange(2))]
    sequence = Sequence("iga", True, levels, links=[each], parts=parts)
    members = tuple(Member(v, inf, inf, "undecided", None, 1) for v in met)
    judged = Judged(members, (Cluster((None, np.arange(2)), True),), Window())
    aim = wanted(judged, sequence, Request("disc_pad"), scene, 1.0, spare=0.0)
    assert len(aim.errors) == 3  # both members, and growth of the one that grows
    assert aim.errors[2] == pytest.approx([wrong * 1e4 / 100.0, 0.0, 0.0], rel=0.02)


PAIR_MESHES = (
    resolution(),
    resolution(disc=(1.0, 1.3, 1.0), pad=(1.15, 1.0, 1.0)),
    resolution(disc=(1.0, 1.8, 1.0), pad=(1.6, 1.0, 1.0)),
)


def of_pair(owed, squares, mean=-1e8):
    """History of a pair whose squared splitting has the parts given, on three meshes."""

    def pair(square):
        apart = np.sqrt(complex(square))
        return np.sqrt(np.array([mean + apart, mean - apart], complex))

    first = pair(squares[0])
    corrected = np.array([pair(squares[0] + part) for part in owed])
    strained, known = np.ones((3, 2)), np.full(2, True)
    parts = Parts(PARTS, np.ones(3), first, corrected, strained, known, False, PAIR_MESHES[0], 0)
    levels = [
        SimpleNamespace(
            eigenvalues=pair(square),
            uncertainties=np.zeros(2),
            residuals=np.zeros(2),
            rigid=np.zeros(2, dtype=bool),
            resolution=mesh,
        )
        for square, mesh in zip(squares, PAIR_MESHES, strict=True)
    ]
    sequence = Sequence("iga", True, levels, parts=parts)
    return history_of(Cluster((np.arange(2),) * 3, False), sequence), parts


@pytest.mark.parametrize("seen", [1.0, 0.7])
def test_parts_of_a_splitting_may_take_off_from_one_another(seen):
    """Where it changed as they then say, up to a factor, and not where it did otherwise."""
    owed, true = np.array([-1.5e13, 0.0, 3e13]), 6e13
    _, parts = of_pair(owed, [true] * 3)
    own, local = owed[None], parts.local(owed / (4e8 * np.sqrt(true)), np.arange(2))[None]
    left = np.concatenate([parts.at(mesh, own, local) for mesh in PAIR_MESHES])
    squares = true - seen * left.sum(axis=1)
    history, _ = of_pair(owed, squares)
    signed, sizes = positions_of(left, owed), positions_of(np.abs(left), owed)
    assert abs(signed[1] - sizes[1]) > 0.3
    assert history.of_splitting == pytest.approx(signed, rel=0.05)
    error = abs(squares[-1] - true)
    rate = observed_rate(history.of_splitting, np.abs(np.diff(squares)))
    assert rate == pytest.approx(1.0, rel=0.1)
    size = bar(squares.tolist(), history.of_splitting, None, usual=Usual(0.0, own=True)).size
    assert error < size < 8 * error
    squares[1] = squares[0] + 0.4 * (squares[1] - squares[0])
    otherwise, _ = of_pair(owed, squares)
    assert otherwise.of_splitting == pytest.approx(sizes, rel=0.05)


def test_a_degree_more_of_lagrange_elements_is_trusted_with_a_tenth():
    """Whatever its parts let expect: the same numbers have wider bars where it is raised last."""
    bars = {}
    for backend in ("fe", "iga"):
        fine = (2.0, 2.0, 2.0)
        meshes = [resolution(), resolution(fine), resolution(fine, degree=4)]
        values = [1j * (1 + e) for e in (1e-3, 1e-5, 1e-7)]
        parts = parts_of([1e-3, 0.0, 0.0])
        levels = [
            SimpleNamespace(
                eigenvalues=np.array([v]),
                uncertainties=np.zeros(1),
                residuals=np.zeros(1),
                rigid=np.zeros(1, dtype=bool),
                resolution=mesh,
            )
            for v, mesh in zip(values, meshes, strict=True)
        ]
        found = Sequence(backend, True, levels, parts=parts)
        history = history_of(Cluster((np.zeros(1, dtype=int),) * 3, False), found)
        bars[backend] = np.diff(history.positions)
    assert bars["fe"][0] == bars["iga"][0]
    assert bars["fe"][1] == pytest.approx(log(10.0))
    assert bars["iga"][1] > 1.2 * log(10.0)


def test_meshes_that_memory_does_not_hold_take_for_ever(backend, monkeypatch):
    scene = load_scene("disc_pad")
    small, large = (counted(scene, backend, Resolution(2, density)) for density in (0.5, 1.0))
    times = Estimates(scene, backend)
    room = 0.5 * sum(estimated_memory(refined(scene, backend, r)).bytes for r in (small, large))
    monkeypatch.setattr("comparisons.converge.levels.available_memory", lambda: room / 0.9)
    taken = times.fitting()
    assert taken(small) == times.seconds(small) < inf
    assert taken(large) == inf > times.seconds(large)


def test_solves_may_leave_a_tenth_of_what_the_digits_allow():
    scene = load_scene("disc_pad")  # digits of growth below 10 1/s are not asked for
    values = np.array([1e4j, 100 + 1e4j, -1 + 1e4j])
    found = may_remain(values, Request("disc_pad", digits=3), scene)
    assert found == pytest.approx([0.5, 0.05, 0.005], rel=1e-3)


# Resolutions


def test_bodies_have_resolutions_of_their_own(backend):
    scene = load_scene("disc_pad")
    mesh = resolution(disc=(0.5, 0.25, 1.0), pad=(1.0, 1.0, 1.0), degree=2)
    mesh = mixed({**dict(mesh.bodies), "pad": BodyResolution(3, (0.5, 0.5, 0.5))})
    finer = refined(scene, backend, mesh)
    on = {n: b.mesh.fe if backend == "fe" else b.mesh.iga for n, b in finer.bodies.items()}
    given = given_elements(scene, backend)
    for name, factors in (("disc", (0.5, 0.25, 1.0)), ("pad", (0.5, 0.5, 0.5))):
        assert on[name].elements == tuple(
            int(np.ceil(n * f)) for n, f in zip(given[name], factors, strict=True)
        )
    assert np.max(on["pad"].degree) == 3
    assert np.max(on["disc"].degree) == 2
    assert (mesh.degree, mesh.layers) == (3, 0)


def test_counted_densities_make_the_same_mesh(backend):
    scene = load_scene("disc_pad")
    for given in (Resolution(2, 0.01), Resolution(2, 0.37, 1)):
        same = counted(scene, backend, given)
        assert refined(scene, backend, same) == refined(scene, backend, given)
        assert counted(scene, backend, same) == same
