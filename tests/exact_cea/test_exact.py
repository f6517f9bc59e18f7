"""Exact eigenvalues: stored facts, two methods against each other, completeness, refusals."""

import json
import math
from decimal import Decimal

import numpy as np
import pytest
from flint import acb
from reference_data import eigenvalues as values_of
from reference_data import stored
from typer.testing import CliRunner

from cea.errors import InputError
from comparisons.accuracy.problems import PROBLEMS, exact
from comparisons.cli.exact import app
from exact_cea import entries, galerkin_problems, lumped
from exact_cea.blocks import Blocks
from exact_cea.drum import Drum
from exact_cea.galerkin import lowest, lowest_in
from exact_cea.galerkin_problems import Ring
from exact_cea.material import Material
from exact_cea.numbers import Exact
from exact_cea.reference import exact_eigenvalues, whole_spectrum
from exact_cea.roots import Box, RootFinder
from exact_cea.solve import spectrum
from exact_cea.thresholds import mu_critical


def apart(found, reference):
    """Largest relative distance of two lists by rising frequency, in the digits of their texts."""
    assert len(found) == len(reference)
    worst = Decimal(0)
    for x, y in zip(by_frequency(found), by_frequency(reference), strict=True):
        re, im = (Decimal(a) - Decimal(b) for a, b in zip(x, y, strict=True))
        size = abs(complex(float(y[0]), float(y[1])))
        worst = max(worst, (abs(re) + abs(im)) / Decimal(size))
    return float(worst)


def by_frequency(pairs):
    return sorted(pairs, key=lambda z: (round(float(z[1]), 9), float(z[0])))


def just_above(lam):
    return float(lam[-1][1]) * (1 + 1e-6)


def distance_to(values, reference):
    """Relative distance of each value to the nearest reference."""
    values, reference = np.asarray(values), np.asarray(reference)
    return (abs(values[:, None] - reference) / abs(reference)).min(axis=1)


def assert_same(values, reference, tolerance):
    """The same numbers, as sets with multiplicities, relative to each."""
    left = list(reference)
    assert len(values) == len(left)
    for value in values:
        nearest = int(np.argmin(abs(np.array(left) - value)))
        assert abs(left.pop(nearest) - value) < tolerance * abs(value)


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


DRUMS = stored("drum_2d") + stored("drum_3d")


def test_the_drum_to_19_digits_and_nothing_missing():
    """One in 3D; one in 2D is compared where the command line is tested."""
    entry = DRUMS[37]
    lam = entry["lam"][:8]
    problem = Drum.of(entry["m"], entry["p"], entry["mu"], entry.get("kz"))
    found = entries.drum(problem, max_frequency=just_above(lam))
    assert found["digits"] >= 20
    assert {key: found[key] for key in entry if key != "lam"}.items() <= entry.items()
    assert apart(found["lam"], lam) < 1e-19


@pytest.mark.parametrize("i", [2, *map(slow, (0, 1, 3, 4, 5, 6))])
def test_blocks_with_sinusoidal_friction_to_16_digits(i):
    entry = stored("blocks_sine_mu")[i]
    problem = Blocks.of(entry["p"], entry["mu0"], entry["kz"])
    found = entries.blocks_sine(problem, max_frequency=just_above(entry["lam"]))
    assert apart(found["lam"], entry["lam"]) < 1e-16


@pytest.mark.slow
@pytest.mark.parametrize("p", ["1", "10"])
def test_thresholds_of_the_blocks_to_19_digits(p):
    points = entries.thresholds(Blocks.of(p), 1.0, max_frequency=3.5)
    found = {point["omega"][:12]: point for point in points}
    for entry in stored("blocks_sine_mu_thresholds"):
        if entry["p"] == p:
            point = found[entry["omega"][:12]]
            for name in ("mu_c", "lam2", "omega"):
                assert abs(Decimal(point[name]) / Decimal(entry[name]) - 1) < Decimal("1e-19")


@pytest.mark.parametrize("i", range(10))
def test_lumped_systems(i):
    entry = stored("lumped")[i]
    exact = [[[Exact(x).rational for x in row] for row in entry[name]] for name in "MCK"]
    found = entries.lumped_system(lumped.LumpedSystem(entry["name"], *exact), {})
    # Doubles stand for thirds in some entries: the closed forms below keep their digits.
    assert apart(found["lam"], entry["lam"]) < 3e-16


def test_constant_friction_with_corner_singularities_to_9_digits_on_a_coarse_grid():
    entry = stored("blocks_constant_mu")[2]
    problem = Blocks.of(entry["p"], entry["mu"])
    values = lowest(galerkin_problems.blocks(problem, 10, 3, constant=True), 18, problem.scale())
    assert_same(values, values_of(entry), 2e-9)


@pytest.mark.parametrize(
    ("i", "degree", "layers", "tolerance"),
    [(0, 10, 1, 2e-9), *(slow(i, 13, 1, 1e-10) for i in range(18))],
)
def test_the_stored_rings_on_other_grids(i, degree, layers, tolerance):
    """The 17 values that hold their digits; the rigid rotation is stored as its round-off."""
    entry = stored("ring_rollers")[i]
    problem = Ring.of(entry["m"], entry["p"], entry["mu"])
    values = lowest(galerkin_problems.ring(problem, degree, layers), 20, problem.scale())[:17]
    expected = values_of(entry)[:17]
    assert (abs(values - expected) / np.maximum(abs(expected), problem.scale())).max() < tolerance


def random_problems(seed):
    """A random drum and a random pair of blocks: each, its matrices by Galerkin, a tolerance."""
    rng = np.random.default_rng(seed)
    p = rng.choice(["0.2", "3", "150", "inf"])
    kz = rng.choice([None, "pi/2", "2.1"])
    mu = f"{rng.uniform(0, 1.2):.3f}"
    materials = [
        Material.of(f"{rng.uniform(*E):.3f}", f"{rng.uniform(0.05, 0.42):.3f}", f"{rho:.3f}")
        for E, rho in (((0.05, 0.5), rng.uniform(0.2, 1)), ((0.5, 2), rng.uniform(0.5, 2)))
    ]
    radii = [f"{r:.2f}" for r in np.cumsum(rng.uniform(0.3, 0.7, 3))]
    drum = Drum.of(int(rng.integers(0, 7)), p, mu, kz, *materials, *radii)
    sizes = [f"{s:.2f}" for s in rng.uniform((0.3, 0.5, 1.2), (0.8, 1.2, 2.2))]
    blocks = Blocks.of(p, mu, kz, *materials, *sizes)
    yield drum, galerkin_problems.drum(drum, 36), 1e-10
    yield blocks, galerkin_problems.blocks(blocks, 22, 0, constant=False), 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_determinant_and_galerkin_agree_for_random_problems(seed):
    for problem, by_galerkin, tolerance in random_problems(seed):
        found = spectrum(problem, count=8)
        exact = found.values + [complex(value) for value in found.contact_free]
        galerkin = lowest(by_galerkin, len(exact) + 2, problem.scale())
        # The list may end between the two of a pair: the second is then beyond it.
        inside = galerkin[galerkin.imag < max(value.imag for value in exact) * (1 - 1e-7)]
        assert distance_to(exact, galerkin).max() < tolerance
        assert distance_to(inside, exact).max() < tolerance


def test_roots_of_a_known_function_are_counted_and_found_with_a_close_pair():
    roots = [1j, 0.3 + 2j, -0.3 + 2.0001j, 0.2 + 2.0002j, 2.5j, 0.1 + 3.9j, 5j]

    def f(kappa):
        value = acb(1)
        for root in roots:
            value *= kappa - acb(root) ** 2
        return value

    box = Box(-1, 1, 0, 4)
    finder = RootFinder(f, turning=2.0)
    count = finder.count(box)
    assert count == 6
    assert_same(finder.roots(box, count), roots[:6], 1e-9)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ("drum --m -1", "m"),
        ("drum --m 1 --inner 2", "inner"),
        ("drum --m 1 --nu-a 0.5", "a.nu"),
        ("drum --m 1 --kz pie", "kz"),
        ("drum --m 1 --count 3 --max-frequency 3", "max_frequency"),
        ("blocks --mu 0.3 --mu0 0.3", "mu"),
        ("blocks --thresholds", "max_frequency"),
        ("drum --m 1 --p 1e-999999999", "p"),
        ("drum --m 1 --max-frequency nan", "max_frequency"),
        ("drum --m 1 --json /", "json"),
    ],
)
def test_wrong_parameters_are_refused_by_name(arguments, field):
    error = CliRunner().invoke(app, arguments.split()).exception
    assert isinstance(error, InputError)
    assert error.field.startswith(field)


def test_command_writes_entries_of_the_stored_form(tmp_path):
    file = tmp_path / "new" / "drum.json"
    arguments = ["drum", "--m", "1", "--m", "2", "--p", "1", "--count", "3", "--json", str(file)]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    first, second = json.loads(file.read_text())
    stored_first = next(e for e in DRUMS if (e["m"], e["p"], e["mu"]) == (1, "1", "0.3"))
    assert set(stored_first) <= set(first)
    assert apart(first["lam"], stored_first["lam"][:3]) < 1e-19
    assert second["m"] == 2


def test_the_whole_drum_has_every_order_of_both_signs_that_galerkin_finds():
    found = whole_spectrum("drum", max_frequency=2.0, mu=0.7)
    for m in range(5):
        problem = Drum.of(m, mu="0.7")
        galerkin = lowest_in(galerkin_problems.drum(problem), problem.scale(), 2.0)
        assert_same(found.values[found.orders == m], galerkin, 1e-9)
        assert_same(found.values[found.orders == -m], -galerkin.conj(), 1e-9)
    assert abs(found.orders).max() == 3
    assert not found.families.any()
    assert (np.diff(found.values.imag) >= 0).all()


def test_blocks_with_depth_are_the_union_of_families_with_the_modes_that_contact_leaves_alone():
    found = whole_spectrum("blocks", max_frequency=1.6, depth=2, mu=0.7)
    kzs = [None, "pi/2", "pi"]
    for j, kz in enumerate(kzs):
        blocks = Blocks.of("1", "0.7", kz)
        galerkin = lowest_in(
            galerkin_problems.blocks(blocks, 14, 0, constant=False), blocks.scale(), 1.6
        )
        assert_same(found.values[found.families == j], galerkin, 1e-8)
    assert set(found.families) == {0, 1, 2}
    speed = math.sqrt(0.1 / 2.5 / 0.35)
    shear = speed * math.hypot(math.pi / 2, math.pi / 2, math.pi)
    assert abs(found.values[found.families == 1] - 1j * shear).min() < 1e-14


def test_where_flutter_begins_in_closed_form_and_for_circles():
    assert mu_critical("hoffmann") == 0.46875
    assert abs(mu_critical("hulten") - 0.44 / 2.4) < 1e-16
    assert mu_critical("drum", m=3) == mu_critical("ring", m=1) == 0
    assert mu_critical("drum", m=0) == math.inf
    for mu, grows in ((0.46874, False), (0.46876, True)):
        matrix = np.array([[2.5, 0.5 - mu * 4 / 3], [0.5, 2]])
        assert (abs(np.linalg.eigvals(matrix).imag).max() > 0) == grows


@pytest.mark.slow
def test_where_flutter_begins_with_constant_friction():
    mu = mu_critical("blocks_constant", p=1, max_frequency=3.0)
    blocks = [Blocks.of(1, mu * factor) for factor in (1 - 1e-7, 1 + 1e-7)]
    before, after = (
        lowest(galerkin_problems.blocks(problem, 13, 4, constant=True), 12, problem.scale())
        for problem in blocks
    )
    assert (before.real / abs(before)).max() < 1e-7
    assert (after.real / abs(after)).max() > 5e-7


@pytest.mark.parametrize(
    ("solve", "arguments", "field"),
    [
        (exact_eigenvalues, {"problem": "plate", "count": 1}, "problem"),
        (exact_eigenvalues, {"problem": "drum", "count": 1}, "m"),
        (exact_eigenvalues, {"problem": "ring", "m": 1, "kz": "pi", "count": 1}, "kz"),
        (exact_eigenvalues, {"problem": "drum", "m": 1}, "max_frequency"),
        (whole_spectrum, {"problem": "ring", "max_frequency": 1e4, "depth": 1}, "depth"),
        (mu_critical, {"problem": "blocks"}, "max_frequency"),
        (mu_critical, {"problem": "hoffmann", "k9": 1}, "k9"),
    ],
)
def test_parameters_a_problem_does_not_have_are_refused(solve, arguments, field):
    with pytest.raises(InputError) as refused:
        solve(**arguments)
    assert refused.value.field.startswith(field)


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
def test_lists_that_accuracy_is_measured_by_are_exact(name):
    np.testing.assert_allclose(PROBLEMS[name].exact(1.0), exact(name, 1.0), rtol=1e-11, atol=1e-13)
