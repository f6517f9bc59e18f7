"""Samples of fields that are spread: probabilities of growth, and every sample's certificate."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
import xarray
from mpi import on_ranks
from reduced_blocks import MESHES, flutter_of_the_blocks
from reference_data import plane_meshes, stored
from same_numbers import assert_same
from scipy.stats import kstest, lognorm, norm, truncnorm

from cea.eigen.matching import assign
from cea.errors import InputError
from cea.reduced.full_solves import first_threshold
from comparisons.cli.app import main
from comparisons.sweep.cells import cells_of
from comparisons.sweep.distributions import Distribution, draw, read_distribution
from comparisons.sweep.mapped import mapped
from comparisons.sweep.probabilities import of_modes, warnings_of, wilson
from comparisons.sweep.sample_page import read_samples, write_samples
from comparisons.sweep.sample_study import AskedSamples, run_samples
from comparisons.sweep.sampled import Sampled

MU, P = "contacts.interface.mu", "contacts.interface.P"


def overrides(backend):
    """The blocks about the first threshold that their exact solution knows."""
    entry = stored("blocks_sine_mu_thresholds")[0]
    top = 1.2 * float(entry["omega"]) / (2 * np.pi)
    return (
        "contacts.interface.mu='sin(pi*x/2)'",
        f"contacts.interface.p={float(entry['p'])}",
        f"analysis.max_frequency={top}",
        "analysis.growth_threshold=1e-6",  # next to the threshold growth is slow
        *(f"bodies.{name}.backend='{backend}'" for name in ("upper", "lower")),
        *plane_meshes(backend, 2, MESHES[backend]),
    )


def asked(backend, *distributions, count=400, **options):
    spread = tuple(map(read_distribution, distributions))
    return AskedSamples("blocks", spread, count, overrides=overrides(backend), **options)


MU_C = float(stored("blocks_sine_mu_thresholds")[0]["mu_c"])


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Samples of mu about its threshold for each backend, made once."""
    known = {}

    def of(backend):
        if backend not in known:
            folder = tmp_path_factory.mktemp("samples") / "out"
            wanted = asked(backend, f"mu~uniform:{0.93 * MU_C}:{1.08 * MU_C}", count=800, seed=5)
            data, drawn, found, store = run_samples(wanted, folder)
            write_samples(data, drawn, found, folder)
            store.discard()
            known[backend] = data, drawn, found, folder
        return known[backend]

    return of


@pytest.mark.grid(quick=1)
def test_the_probability_of_growth_is_that_of_passing_the_threshold(made, backend):
    """Only mu varies: what grows is what was drawn above mu_c, sample by sample."""
    data, drawn, found, _ = made(backend)
    driver, name, bracket, top = flutter_of_the_blocks(backend)
    threshold = first_threshold(driver, name, *bracket, max_frequency=top).value
    driver.free()
    values = np.array(drawn[0].values)
    far = np.abs(values - threshold) > 1e-6 * threshold
    np.testing.assert_array_equal(found.grows.any(axis=1)[far], (values > threshold)[far])
    exact = (1.08 * MU_C - threshold) / (0.15 * MU_C)
    assert data["any"]["low"] <= exact <= data["any"]["high"]
    assert abs(data["any"]["probability"] - exact) < 4 * data["any"]["standard_error"]
    assert data["certified"] == data["samples"] == 800


@pytest.mark.slow
def test_the_probability_is_that_of_the_exact_threshold_on_a_fine_mesh(tmp_path):
    """The blocks' own threshold of their exact solution, on cubic elements: off by 1.4e-4."""
    fine = plane_meshes("fe", 3, {"upper": [16, 4], "lower": [12, 6]})
    wanted = asked("fe", f"mu~uniform:{0.95 * MU_C}:{1.08 * MU_C}", count=900, seed=2)
    chosen = tuple(each for each in wanted.overrides if ".mesh." not in each)
    wanted = replace(wanted, overrides=(*chosen, *fine), checks=0)
    data, _, _, store = run_samples(wanted, tmp_path / "out")
    store.discard()
    exact, error = 0.08 / 0.13, data["any"]["standard_error"]
    assert error < 0.017
    assert abs(data["any"]["probability"] - exact) < 3 * error + 2e-4 / 0.13


@pytest.mark.grid(quick=1)
def test_both_modes_that_coalesce_are_named_and_no_other(made, backend):
    data, _, found, _ = made(backend)
    assert len(data["modes"]) == 2
    for mode in data["modes"]:
        assert mode["grows"] == data["any"]["grows"]
        assert mode["seen"] == 800
    grows = found.grows.any(axis=1)
    assert (found.grows[grows].sum(axis=1) == 2).all()
    assert data["any"]["fastest"] == pytest.approx(found.growth[grows].max())
    ordered = np.sort(found.growth[grows].max(axis=1))
    assert data["any"]["growth"]["median"] == pytest.approx(np.median(ordered))


def test_modes_that_continue_none_are_told_apart_from_those_that_are_not_there():
    nan = np.nan
    yes, no = True, False
    found = Sampled(
        growth=np.array([[5.0, 7.0], [-1.0, nan], [6.0, nan]]),
        frequency=np.array([[100.0, 130.0], [90.0, nan], [110.0, nan]]),
        uncertainty=np.array([[0.1, 0.1], [0.1, nan], [0.1, nan]]),
        number=np.array([[0, -1], [-1, -1], [0, -1]]),
        grows=np.array([[yes, yes], [no, no], [yes, no]]),
        may_grow=np.array([[yes, yes], [no, no], [yes, no]]),
        worst=np.zeros(3),
        bound=np.zeros(3),
    )
    followed, others = of_modes(found)
    assert (followed["mode"], followed["seen"], followed["grows"]) == (0, 2, 2)
    assert (others["mode"], others["seen"], others["grows"]) == (None, 2, 1)
    assert (others["frequency_low"], others["frequency_high"]) == (90.0, 130.0)
    assert others["fastest"] == 7.0
    told = {
        "samples": 3,
        "certified": 3,
        "any": {"undecided": 0},
        "modes": [followed, others],
        "failed": [],
        "snapshots": [],
    }
    assert [each["kind"] for each in warnings_of(told, 1e-8)] == ["not-followed"]


def test_samples_are_those_of_full_solves(backend, tmp_path):
    """Every parameter of the undamped scene is spread."""
    spread = (
        f"mu~normal:{MU_C}:{0.1 * MU_C}:0:1",
        "P~lognormal:1:0.2",
        "bodies.upper.material.E~normal:1:0.03",
        "bodies.lower.material.rho~uniform:0.9:1.1",
    )
    wanted = asked(backend, *spread, count=60, seed=1)
    data, drawn, found, store = run_samples(wanted, tmp_path / "out")
    store.discard()
    assert data["certified"] == 60
    scene = mapped("blocks", drawn, wanted.overrides, None)
    for i in (0, 17, 59):
        modes = scene.driver.solve(
            1.02 * scene.max_frequency, scene.point([each.values[i] for each in drawn])
        )
        there = np.isfinite(found.growth[i])
        values = found.growth[i][there] + 2j * np.pi * found.frequency[i][there]
        rows, columns = assign(np.abs(values[:, None] - modes.eigenvalues))
        assert len(rows) == len(values)
        off = np.abs(values[rows] - modes.eigenvalues[columns])
        allowed = found.uncertainty[i][there][rows] + modes.growth_uncertainties[columns]
        assert (off <= allowed).all()
        limit = scene.growth_threshold
        inside = modes.eigenvalues.imag <= 2 * np.pi * scene.max_frequency
        assert found.grows[i].any() == (modes.eigenvalues.real > limit)[inside].any()
    scene.driver.free()


def test_samples_that_are_not_certified_are_counted_and_named(tmp_path):
    wanted = asked("iga", "mu~uniform:0:0.2", "P~lognormal:1:2", most=2, checks=0, count=50)
    data, _, found, store = run_samples(wanted, tmp_path / "out")
    store.discard()
    left = np.flatnonzero(found.bound > 1e-8)
    assert 0 < len(left) == data["samples"] - data["certified"]
    assert data["not_certified"] == left.tolist()
    told = next(each for each in data["warnings"] if each["kind"] == "not-certified")
    assert str(left[0]) in told["message"]


@pytest.mark.slow
def test_samples_leave_a_page_and_are_drawn_anew(made, backend, monkeypatch, capsys):
    data, drawn, found, folder = made(backend)
    names = {"samples.nc", "probability.csv", "samples.csv", "report.html", "samples.png"}
    assert names <= {file.name for file in folder.iterdir()}
    again, modes = read_samples(data, folder / "samples.nc")
    assert again[0].values == drawn[0].values
    np.testing.assert_array_equal(modes.growth, found.growth)
    np.testing.assert_array_equal(modes.grows, found.grows)
    with xarray.open_dataset(folder / "samples.nc", engine="h5netcdf") as opened:
        assert opened.attrs["seed"] == 5
        assert opened.growth.attrs["units"] == "1/s"
    (folder / "report.html").unlink()
    text = f"mu~uniform:{0.93 * MU_C}:{1.08 * MU_C}"
    command = ["cea", "sweep", "blocks", text, "--redraw", "--out", str(folder)]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code, capsys.readouterr().err
    page = (folder / "report.html").read_text()
    assert f"{data['any']['grows']} of 800 samples grow" in page


@pytest.mark.slow
def test_the_command_records_its_seed_and_draws_the_same_again(tmp_path, monkeypatch, capsys):
    settings = [part for each in overrides("iga") for part in ("--set", each)]
    text = f"mu~normal:{MU_C}:{0.01 * MU_C}"
    found = []
    for name in ("one", "other"):
        out = tmp_path / name
        options = ["--samples", "20", "--seed", "7", *settings, "--out", str(out)]
        monkeypatch.setattr(sys, "argv", ["cea", "sweep", "blocks", text, *options])
        with pytest.raises(SystemExit) as end:
            main()
        assert not end.value.code, capsys.readouterr().err
        data = json.loads((out / "result.json").read_text())
        assert data["inputs"]["seed"] == 7
        found.append((out / "samples.csv").read_text())
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("mu~normal:0.4:0.05", norm(0.4, 0.05)),
        ("mu~normal:0.1:0.1:0:0.2", truncnorm(-1, 1, 0.1, 0.1)),
        ("P~lognormal:1e9:0.5", lognorm(0.5, scale=1e9)),
    ],
)
def test_samples_follow_their_distribution(text, law):
    """Kolmogorov and Smirnov, whose statistic is no chance at this seed."""
    values = draw([read_distribution(text)], 5000, 11)[0].values
    assert kstest(values, law.cdf).pvalue > 0.01
    shifted = replace(read_distribution(text), first=1.3 * read_distribution(text).first)
    assert kstest(draw([shifted], 5000, 11)[0].values, law.cdf).pvalue < 1e-6


def test_fields_are_drawn_independently_and_by_their_seed():
    both = [read_distribution("mu~uniform:0:1"), read_distribution("P~uniform:2:3")]
    one, other = draw(both, 4000, 0)
    assert abs(np.corrcoef(one.values, other.values)[0, 1]) < 0.05
    assert min(other.values) >= 2
    assert draw(both, 4000, 0)[0].values == one.values
    assert draw(both, 4000, 1)[0].values != one.values


def test_cells_hold_every_sample_once_and_begin_in_the_middle():
    spread = np.random.default_rng(2).random((2, 1000))
    cells = cells_of(spread)
    assert sorted(np.concatenate([cell.samples for cell in cells])) == list(range(1000))
    assert max(len(cell.samples) for cell in cells) <= 128
    assert all(cell.middle in cell.samples for cell in cells)
    assert np.abs(spread[:, cells[0].middle] - 0.5).max() < 0.3


def test_intervals_of_wilson():
    """Five of ten: 0.2366 to 0.7634 (Brown, Cai, DasGupta, Statist. Sci. 16 (2001))."""
    assert wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    assert wilson(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert wilson(10, 10) == pytest.approx((0.7225, 1.0), abs=1e-4)


@pytest.mark.parametrize(
    "text",
    [
        "mu",
        "mu~",
        "mu~gamma:1:2",
        "mu~normal:1",
        "mu~uniform:0:1:0:1",
        "~normal:0:1",
        "mu~normal:a:1",
    ],
)
def test_texts_that_are_no_distribution_are_refused(text):
    with pytest.raises(InputError, match="name~normal"):
        read_distribution(text)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("mu", "normal", 0.4, 0.0), "positive deviation"),
        (("mu", "normal", np.inf, 1.0), "finite"),
        (("mu", "uniform", 1.0, 1.0), "greater than 1"),
        (("mu", "lognormal", -1.0, 1.0), "positive, at least 1e-30"),
        (("mu", "normal", 0.0, 1.0, 2.0, 1.0), "greater than 2"),
        (("mu", "normal", 0.0, 1.0, 50.0, 51.0), "between them"),
    ],
)
def test_distributions_that_are_none_are_refused(arguments, told):
    with pytest.raises(InputError, match=told):
        Distribution(*arguments)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["mu~normal:0.4:0.05", "P=1:2:3"], "as the others are"),
        (["mu~normal:0.4:0.05", "--full"], "full"),
        (["mu~normal:0.4:0.05", "--confirm", "5"], "confirm"),
        (["mu~normal:0.4:0.05", "--samples", "1"], "2 to"),
        (["mu~normal:0.4:0.05", "--seed", "-1"], "zero or more"),
        (["mu=0:1:3", "--samples", "5"], "distributions"),
        (["mu=0:1:3", "--seed", "5"], "distributions"),
        (["mu~normal:0:1"], "zero or positive"),
    ],
)
def test_commands_that_ask_for_no_samples_are_refused(words, told, monkeypatch, capsys, tmp_path):
    command = ["cea", "sweep", "blocks", *words, "--out", str(tmp_path / "out")]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code
    assert told in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.mpi
def test_samples_are_the_same_on_several_ranks():
    alone = on_ranks(1, "sampled_numbers.numbers")
    assert_same(on_ranks(2, "sampled_numbers.numbers"), alone, rel=1e-8)
