"""The same answers on 1, 2 and 3 ranks, and one voice whatever goes wrong."""

import json
import sys
from time import monotonic

import numpy as np
import pytest
from mpi import cea_on_ranks, mpiexec, on_ranks
from parallel_cases import CASES
from same_numbers import assert_same
from scipy.optimize import linear_sum_assignment

pytestmark = pytest.mark.mpi


QUICK = {
    2: (
        "fe collocation", "fe static gpts", "fe static full pass", "fe static mortar",
        "iga gpts", "iga static collocation", "iga static grid", "iga static lumped",
        "iga static segments", "iga static tied mortar",
        "fe without friction", "fe static without friction",
        "iga without friction", "iga static without friction",
        "fe overhanging", "fe single point", "fe column", "fe disc_pad",
        "iga overhanging", "iga single point", "iga column", "iga disc_pad",
        "several discs", "fe on iga", "iga on fe",
    ),
    3: ("fe static without friction", "iga static gpts"),
}  # fmt: skip
"""Cases of the quick tests by number of ranks: every kind on each backend, and the cheapest."""
slow = pytest.mark.slow


def assert_same_eigenvalues(found, expected):
    """Equal to 1e-9 as sets; of a near-coalescence only the mean of the pair is well conditioned.

    lambda = +-w + i w' near a coalescence: rounding e of kappa moves the members by sqrt(e), their
    mean by e.
    """
    left, right = (np.array(v["re"]) + 1j * np.array(v["im"]) for v in (found, expected))
    assert len(left) == len(right)
    rows, columns = linear_sum_assignment(np.abs(left[:, None] - right))
    left, right = left[rows], right[columns]
    scale = np.abs(right)
    loose = np.abs(left - right) > 1e-9 * scale
    for i in np.flatnonzero(loose):
        others = np.flatnonzero(loose & (np.arange(len(right)) != i))
        assert len(others), (left[i], right[i])
        partner = others[np.argmin(np.abs(right[others] - right[i]))]
        assert abs(right[partner] - right[i]) < 1e-3 * scale[i]
        assert abs(left[[i, partner]].mean() - right[[i, partner]].mean()) < 1e-9 * scale[i]


@pytest.mark.parametrize(
    ("ranks", "name"),
    [
        pytest.param(ranks, name, marks=() if name in QUICK[ranks] else slow)
        for ranks in QUICK
        for name in CASES
    ],
)
def test_answers_do_not_depend_on_the_number_of_ranks(ranks, name):
    found, expected = (dict(on_ranks(n, "parallel_cases.case", name)) for n in (ranks, 1))
    asymmetry = found.pop("asymmetry")
    assert asymmetry == expected.pop("asymmetry") == [0.0] * len(asymmetry)
    if "im" in expected:
        assert len(expected["im"]) >= 3
        worst = 1e-9 if "disc_pad" in name else 1e-7
        assert found.pop("worst_residual") < worst > expected.pop("worst_residual")
        assert_same_eigenvalues(found, expected)
        shapes, expected_shapes = found.pop("shapes"), expected.pop("shapes")
        if name.split()[-1] != "column":  # copies of one frequency have no shape of their own
            largest = np.max(shapes, initial=0.0)
            np.testing.assert_allclose(shapes, expected_shapes, atol=1e-6 * largest)
        for part in ("re", "im"):
            found.pop(part)
            expected.pop(part)
    assert_same(found, expected)


@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=slow)])
def test_forces_on_ranks_without_displacements(ranks):
    found, expected = (on_ranks(n, "parallel_cases.saddle") for n in (ranks, 1))
    assert len(found["im"]) > 3
    for name, values in expected.items():
        assert sorted(found[name]) == pytest.approx(sorted(values), rel=1e-9, abs=1e-12)


def test_the_disc_and_pad_flutters_on_coarse_meshes(backend):
    assert max(on_ranks(1, "parallel_cases.case", f"{backend} disc_pad")["re"]) > 100


def test_command_line_prints_and_writes_once(tmp_path):
    command = ["run", "patch_test", "--set", "contacts.interface.formulation.points=3"]
    done = cea_on_ranks(2, *command, "--set", "analysis.samples=4", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("result.json") == 1
    assert done.stdout.count("side b") == 1
    (tmp_path / "mode_1.png").write_text("mine")
    more = ["--set", "analysis.samples=4", "--set", "output.paraview=1"]
    for arguments, files in ((more, {"displacement.pvd"}), (more[:2], set())):
        done = cea_on_ranks(2, *command, *arguments, "--out", tmp_path)
        assert done.returncode == 0, done.stderr
        found = {path.name for path in tmp_path.glob("*") if path.is_file()}
        assert found - {"contacts.pvd"} == {"manifest.json", "mode_1.png", "result.json"} | files
    alone = cea_on_ranks(1, *command, "--set", "analysis.samples=4", "--out", tmp_path / "alone")
    assert alone.returncode == 0, alone.stderr
    together, single = (
        json.loads((folder / "result.json").read_text())
        for folder in (tmp_path, tmp_path / "alone")
    )
    for result in (together, single):
        del result["timings"], result["seconds"]
    assert_same(together["stresses"], single["stresses"])
    assert_same(together["contacts"], single["contacts"])
    assert together.keys() == single.keys()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["patch_test", "--set", "analysis.foo=3"], "error: analysis.foo = "),
        (["patch_test", "--set", "contacts.interface.a=upper.x_min"], "error: contacts.interface"),
        (["patch_test", "--no-such-option"], "No such option"),
    ],
)
def test_faults_of_all_ranks_are_told_once(arguments, told, tmp_path):
    done = cea_on_ranks(2, "run", *arguments, "--out", tmp_path)
    assert done.returncode not in (0, None)
    assert done.stderr.count(told) == 1
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "result.json").exists()


LONE_FAULT = """
import sys
import scenes.running.system
from mpi4py import MPI

search = scenes.running.system.build_contacts
faulty = int(sys.argv.pop())


def fails_on_one_rank(*arguments):
    if MPI.COMM_WORLD.rank == faulty:
        raise RuntimeError("only one rank")
    return search(*arguments)


scenes.running.system.build_contacts = fails_on_one_rank
from comparisons.cli.app import main

main()
"""


@pytest.mark.parametrize("rank", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_a_fault_of_one_rank_ends_all(rank, tmp_path):
    start = monotonic()
    arguments = ["run", "patch_test", "--backend", "iga", "--out", tmp_path, str(rank)]
    done = mpiexec(2, sys.executable, "-c", LONE_FAULT, *arguments)
    assert done.returncode != 0
    assert done.stderr.count("RuntimeError: only one rank") == 1
    assert not (tmp_path / "result.json").exists()
    assert monotonic() - start < 30
