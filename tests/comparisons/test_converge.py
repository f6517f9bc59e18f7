"""``cea converge``: bars beside exact eigenvalues, what is said where digits are not reached."""

import json
from itertools import count
from math import pi

import numpy as np
import pytest
from file_scenes import built, from_file
from mpi import on_ranks
from reference_data import COALESCENCES
from reference_data import exact as whole_spectrum

from cea.eigen.matching import assign
from cea.errors import ConvergenceError, InputError
from comparisons.converge import ladder
from comparisons.converge.bars import pair
from comparisons.converge.ladder import RATIO, Ladder
from comparisons.converge.page import write_converge
from comparisons.converge.request import Request
from comparisons.converge.study import run_converge
from comparisons.study.result import read_result
from comparisons.study.session import Progress
from scenes import run_modes
from scenes.spec.plain import scene_text
from scenes.spec.reading import load_scene, read_scene

UNIT = {"drum": 1.0, "blocks": 1.0, "ring": 1e12}
"""Contact stiffness p of scenes with exact eigenvalues (N/m^3)."""


def converged(scene, **options):
    return run_converge(Request(scene, **options), Progress())


def exact(name, p=1.0, mu=0.3):
    """Eigenvalues of a scene to a little beyond its window; p relative to its own."""
    highest = 2 * pi * load_scene(name).analysis.max_frequency
    return whole_spectrum(name, highest, p=repr(p * UNIT[name]), mu=repr(mu))


def shares(data, exact):
    """Errors over bars, and relative errors, of the modes that are not rigid."""
    modes = [mode for mode in data["modes"] if not mode["rigid"]]
    values = np.array([m["growth"] + 2j * pi * m["frequency"] for m in modes])
    bars = np.array([np.hypot(2 * pi * m["frequency_bar"], m["growth_bar"]) for m in modes])
    rows, columns = assign(np.abs(values[:, None] - exact))
    assert len(rows) == len(values)
    errors = np.abs(values - exact[columns])
    return errors / bars, errors / np.abs(exact[columns])


@pytest.mark.parametrize("splitting", [0.04, 0.0, -0.04])
@pytest.mark.parametrize("damped", [True, False])
def test_bars_of_a_pair_hold_its_members_through_a_coalescence(splitting, damped):
    """Mean and splitting converge; members move like roots of the error."""
    errors = np.array([0.03 * RATIO ** (-4 * i) for i in range(3)] + [0.0])
    z = -9 + errors[:, None] + np.sqrt(splitting + errors + 0j)[:, None] * np.array([1, -1])
    *lam, truth = z if damped else np.sqrt(z)
    for own, true in zip(pair(np.array(lam), lam[-1], 2, 0.0, damped=damped), truth, strict=True):
        assert abs(own.value.imag - true.imag) <= own.frequency_bar * (1 + 1e-6)
        assert abs(own.value.real - true.real) <= own.growth_bar * (1 + 1e-6)
        if not damped:
            assert own.is_open == (splitting == 0)
            assert own.still == (splitting > 0)


@pytest.fixture(scope="module")
def result():
    """Blocks to four digits on both backends."""
    return converged("blocks", digits=4)


def test_digits_are_held_and_bars_hold_the_exact_eigenvalues(result):
    assert result["held"]
    assert "4 digits of frequency in 11 of 11 modes, 3 of growth in 1 of 1" in result["first"]
    assert "not reached" not in result["first"]
    share, error = shares(result, exact("blocks"))
    assert (share <= 1).all()
    assert np.median(share) > 0.2
    assert error.max() < 0.5e-4
    assert all(mode["agree"] and mode["estimates"] == 2 for mode in result["modes"])


def test_the_page_and_its_files_tell_what_was_found(result, tmp_path):
    text = write_converge(result, tmp_path).read_text()
    assert result["first"] in text
    stored = read_result(tmp_path, "converge")
    assert stored["modes"] == json.loads(json.dumps(result["modes"]))
    assert (tmp_path / "modes.csv").is_file()
    enough = [e for e in result["levels"] if e["bound"] is not None and e["bound"] <= 0.5e-2]
    best = min(enough, key=lambda level: level["dofs"])
    for name, body in load_scene(tmp_path / "for_sweeps.toml").bodies.items():
        mesh = body.mesh.fe if body.backend == "fe" else body.mesh.iga
        assert list(mesh.elements) == best["elements"][name]


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("factor", "verdicts"),
    [(1.0, ["undecided", "undecided"]), (1.001, ["stable", "unstable"]), (0.999, ["stable"] * 2)],
)
def test_at_a_known_threshold_the_sign_of_growth_is_undecided(backend, factor, verdicts):
    mu = (f'contacts.interface.mu="{COALESCENCES[0][1] * factor!r}*sin(pi*x/2)"',)
    data = converged("blocks", digits=4, backends=(backend,), overrides=mu)
    near = [m for m in data["modes"] if abs(m["frequency"] - 0.46164) < 2e-4]
    assert sorted(mode["verdict"] for mode in near) == verdicts


@pytest.mark.grid(quick=1)
def test_damping_by_the_mass_leaves_the_exact_eigenvalues_known(backend):
    """Lambda^2 + alpha lambda is that of the undamped blocks."""
    alpha = 0.02
    damped = (f"bodies.{body}.damping={{alpha={alpha}}}" for body in ("upper", "lower"))
    overrides = (*damped, "analysis.max_frequency=0.34")
    data = converged("blocks", digits=3, backends=(backend,), overrides=overrides)
    both = -alpha / 2 + np.sqrt(exact("blocks") ** 2 + alpha**2 / 4)
    share, _ = shares(data, np.where(both.imag < 0, -alpha - both, both))
    assert data["held"]
    assert (share <= 1).all()


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize(
    ("bodies", "backends"),
    [(("upper",), ("fe",)), (("upper",), ("fe", "iga")), (("upper", "lower"), ("fe", "iga"))],
)
def test_bodies_from_mesh_files_have_error_bars(tmp_path, bodies, backends):
    """One or both: bars hold what elements of degree 4 on the same cells give."""
    file = tmp_path / "scene.toml"
    data = from_file(built("hexahedron", 2), tmp_path / "a.msh", bodies=bodies)
    if "lower" not in bodies:
        data["bodies"]["lower"]["mesh"]["iga"] = {"degree": [2, 2, 2], "elements": [4, 2, 2]}
    file.write_text(scene_text(read_scene(data)))
    found = converged(str(file), digits=2, growth_digits=1, backends=backends)
    assert found["levels"][0]["file_degree"] == 1
    assert {mode["estimates"] for mode in found["modes"]} == {1}
    for body in data["bodies"].values():
        own = body["mesh"].get("fe")
        body["mesh"] = {"fe": own | {"degree": 4}} if own else {"degree": 4}
    share, error = shares(found, run_modes(read_scene(data)).eigenvalues)
    assert (share <= 1).all()
    assert found["held"] == ("not reached" not in found["first"])
    assert not found["held"] or error.max() < 0.5e-2


def test_digits_that_are_not_reached_are_told_first_with_code_3(cea):
    given = "--digits", "9", "--backend", "iga", "--budget", "3"
    code, told, fault = cea("converge", "blocks", *given)
    assert code == 3, fault
    first = next(line for line in told.splitlines() if "digits of frequency in" in line)
    assert "not reached: frequency of " in first
    # The next mesh is not begun, or stopped where the machine is slower than it was.
    assert "one more mesh would take about" in first or "was stopped" in first


@pytest.mark.slow
def test_a_mesh_that_cannot_be_corrected_does_not_count(monkeypatch):
    """Differences of meshes alone would be bars far too small where one is small by chance."""
    correct = Ladder.correct

    def failing(ladder, mesh, progress):
        if mesh.resolution == ladder.resolution(3):
            raise InputError("mesh", mesh.dofs, "one that fits into memory")
        return correct(ladder, mesh, progress)

    monkeypatch.setattr(Ladder, "correct", failing)
    data = converged("blocks", digits=7, backends=("iga",))
    assert len(data["levels"]) == 3
    assert "iga: no further mesh: mesh = " in data["first"]
    assert all(mode["estimates"] == 2 for mode in data["modes"])
    assert (shares(data, exact("blocks"))[0] <= 1).all()


@pytest.mark.parametrize("fails", [False, True])
def test_too_few_meshes_have_bars_or_do_not_count(fails, monkeypatch):
    """The second mesh fails: the first is corrected in the end, and has bars of one estimate."""

    def failing(*given, **options):
        raise ConvergenceError("lost")

    run = Ladder.run
    monkeypatch.setattr(Ladder, "run", lambda *given: failing() if given[1] else run(*given))
    if fails:
        monkeypatch.setattr(Ladder, "correct", failing)
    data = converged("blocks", digits=2, backends=("iga",))
    if fails:
        assert data["modes"] == []
        assert "no correction of the only meshes: lost" in data["first"]
        return
    assert len(data["levels"]) == 1
    assert {mode["estimates"] for mode in data["modes"]} == {1}
    assert (shares(data, exact("blocks"))[0] <= 1).all()


def test_a_budget_that_is_gone_leaves_no_mesh():
    """Stages that begin after it end the command, on all ranks alike."""
    data = converged("blocks", budget=1e-9)
    assert data["modes"] == data["levels"] == []
    assert data["first"].startswith("not reached: no mesh was solved")


@pytest.mark.slow
def test_bars_are_honest_and_not_wide():
    """98 of 100 eigenvalues in their bars, all within two; five times the error in the median.

    Contact stiffnesses lie over four decades, friction reaches 1.
    """
    found, rng = [], np.random.default_rng(20261122)
    for i, name in enumerate(4 * ("drum", "blocks", "ring")):
        p, mu = (float(f"{x:.3g}") for x in (10 ** rng.uniform(-2, 2), rng.uniform(0.05, 1.0)))
        friction = f'"{mu!r}*sin(pi*x/2)"' if name == "blocks" else repr(mu)
        overrides = {"mu": friction, "p": repr(p * UNIT[name])}
        overrides = tuple(f"contacts.interface.{key}={each}" for key, each in overrides.items())
        digits = 2 if name == "ring" else (2, 3, 5)[i % 3]
        data, known = converged(name, digits=digits, overrides=overrides), exact(name, p, mu)
        found.append(shares(data, known[np.abs(known) > 1e-6 * np.abs(known).max()])[0])
    every = np.concatenate(found)
    assert (every <= 1).mean() >= 0.98
    assert (every <= 2).all()
    assert np.median(every) >= 0.2


def blocks_to_three_digits():
    """What is reached, and frequencies and growth rates with their bars."""
    data = converged("blocks")
    names = ("frequency", "frequency_bar", "growth", "growth_bar")
    return {"first": data["first"], "values": [[m[name] for name in names] for m in data["modes"]]}


@pytest.mark.slow
@pytest.mark.mpi
def test_modes_are_the_same_on_any_number_of_ranks():
    one, several = (on_ranks(n, blocks_to_three_digits) for n in (1, 3))
    assert several["first"] == one["first"]
    np.testing.assert_allclose(several["values"], one["values"], rtol=1e-6, atol=1e-8)


@pytest.mark.slow
def test_meshes_and_bars_do_not_depend_on_the_clock(result, monkeypatch):
    """On a machine that takes a minute for whatever it does."""
    clock = count(step=60)
    monkeypatch.setattr(ladder, "perf_counter", lambda: next(clock))
    slow = converged("blocks", digits=4, budget=1e9)
    assert [each["elements"] for each in slow["levels"] if each["backend"] == "iga"] == [
        each["elements"] for each in result["levels"] if each["backend"] == "iga"
    ]
    assert slow["modes"] == result["modes"]


def test_a_backend_whose_meshes_fail_is_warned_of(monkeypatch):
    run = Ladder.run

    def failing(ladder, number, progress):
        if ladder.backend == "iga":
            raise ConvergenceError("lost")
        return run(ladder, number, progress)

    monkeypatch.setattr(Ladder, "run", failing)
    data = converged("blocks", digits=2, overrides=("analysis.max_frequency=0.3",))
    assert data["held"]
    told = [each["message"] for each in data["warnings"] if each["kind"] == "backend-ended"]
    assert told == ["iga: no further mesh: lost"]
