"""Exact eigenvalues by name: stored values, whole bodies, where flutter begins, refusals."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cea.errors import InputError
from exact_cea import galerkin_problems
from exact_cea.blocks import Blocks
from exact_cea.drum import Drum
from exact_cea.galerkin import lowest, lowest_in
from exact_cea.reference import exact_eigenvalues, whole_spectrum
from exact_cea.thresholds import mu_critical

DATA = Path(__file__).parents[1] / "data"


def stored(name, **chosen):
    """Values of the only stored entry that has the parameters chosen."""
    entries = json.loads((DATA / f"{name}.json").read_text())
    (entry,) = [e for e in entries if all(e[key] == value for key, value in chosen.items())]
    return np.array([complex(float(x), float(y)) for x, y in entry["lam"]])


def assert_same(values, reference, tolerance):
    """The same numbers, as sets with multiplicities, relative to each."""
    left = list(reference)
    assert len(values) == len(left)
    for value in values:
        nearest = int(np.argmin(abs(np.array(left) - value)))
        assert abs(left.pop(nearest) - value) < tolerance * abs(value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("problem", "arguments", "file", "chosen", "tolerance"),
    [
        ("drum", {"m": 2}, "drum_2d", {"m": 2, "p": "1", "mu": "0.3"}, 1e-14),
        (
            "drum",
            {"m": 1, "mu": 0.7, "p": 1e3, "kz": "pi"},
            "drum_3d",
            {"m": 1, "p": "1000"},
            1e-14,
        ),
        ("blocks", {"mu": 1}, "blocks_sine_mu", {"p": "1", "mu0": "1", "kz": None}, 1e-14),
        ("blocks_constant", {"mu": 0.7}, "blocks_constant_mu", {"mu": "0.7"}, 1e-10),
    ],
)
def test_stored_values_by_name(problem, arguments, file, chosen, tolerance):
    reference = stored(file, **chosen)
    values = exact_eigenvalues(problem, count=len(reference), **arguments)
    assert_same(values, reference, tolerance)


def test_a_window_by_frequency_is_one_by_count_and_results_are_kept_and_protected():
    by_count = exact_eigenvalues("drum", m=4, count=5)
    by_frequency = exact_eigenvalues("drum", m=4, max_frequency=by_count[-1].imag + 1e-9)
    np.testing.assert_allclose(by_count, by_frequency, rtol=1e-15)
    assert exact_eigenvalues("drum", m=4, count=5, p="1", mu="0.30") is by_count
    with pytest.raises(ValueError, match="read-only"):
        by_count[0] = 0


def test_turning_against_friction_changes_the_sign_of_growth():
    forward, backward = (exact_eigenvalues("drum", m=m, count=4) for m in (3, -3))
    np.testing.assert_array_equal(forward.imag, backward.imag)
    np.testing.assert_array_equal(forward.real, -backward.real)


def test_the_whole_drum_has_every_order_of_both_signs_that_galerkin_finds():
    found = whole_spectrum("drum", max_frequency=2.4, mu=0.7)
    for m in range(8):
        problem = Drum.of(m, mu="0.7")
        galerkin = lowest_in(galerkin_problems.drum(problem), problem.scale(), 2.4)
        assert_same(found.values[found.orders == m], galerkin, 1e-9)
        assert_same(found.values[found.orders == -m], -galerkin.conj(), 1e-9)
    assert abs(found.orders).max() == 4
    assert not found.families.any()
    assert (np.diff(found.values.imag) >= 0).all()


def test_blocks_with_depth_are_the_union_of_families_with_the_modes_that_contact_leaves_alone():
    found = whole_spectrum("blocks", max_frequency=1.8, depth=2, mu=0.7)
    kzs = [None, "pi/2", "pi", "3*pi/2"]
    for j, kz in enumerate(kzs):
        blocks = Blocks.of("1", "0.7", kz)
        galerkin = lowest_in(
            galerkin_problems.blocks(blocks, 14, 0, constant=False), blocks.scale(), 1.8
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


def test_where_flutter_of_the_blocks_begins_to_all_digits():
    table = json.loads((DATA / "blocks_sine_mu_thresholds.json").read_text())
    first = min(float(entry["mu_c"]) for entry in table if entry["p"] == "1")
    assert abs(mu_critical("blocks", p=1, max_frequency=3.0) / first - 1) < 1e-15


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
    ("arguments", "field"),
    [
        ({"problem": "plate", "count": 1}, "problem"),
        ({"problem": "drum", "count": 1}, "m"),
        ({"problem": "blocks", "m": 1, "count": 1}, "m"),
        ({"problem": "ring", "m": 1, "kz": "pi", "count": 1}, "kz"),
        ({"problem": "drum", "m": 1, "count": 1, "length": 2}, "length"),
        ({"problem": "drum", "m": 1}, "max_frequency"),
        ({"problem": "drum", "m": 1, "count": 1, "outer": 0.9}, "inner"),
    ],
)
def test_parameters_a_problem_does_not_have_are_refused(arguments, field):
    with pytest.raises(InputError) as refused:
        exact_eigenvalues(**arguments)
    assert refused.value.field.startswith(field)


def test_whole_bodies_and_thresholds_refuse_too():
    with pytest.raises(InputError, match="depth"):
        whole_spectrum("ring", max_frequency=1e4, depth=1)
    with pytest.raises(InputError, match="max_frequency"):
        mu_critical("blocks")
    with pytest.raises(InputError, match="k9"):
        mu_critical("hoffmann", k9=1)
