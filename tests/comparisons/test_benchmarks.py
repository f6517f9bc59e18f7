"""`cea bench`: programs and methods that must agree do, and what is measured is what it says."""

from dataclasses import replace
from types import SimpleNamespace

import decks
import numpy as np
import pandas as pd
import pytest
from scipy.sparse.linalg import eigsh

from cea.errors import ConvergenceError
from cea.matrices import local_part
from comparisons.bench import assembly, calculix, scaling, solve
from comparisons.study.measure import measured
from comparisons.study.result import read
from comparisons.study.run import run

BOXES = (2, 3, 1)


def matrices_of(program, family, degree):
    """Stiffness and mass, scipy."""
    made = assembly.PROGRAMS[program](family, degree, BOXES)
    return local_part(made.stiffness()).tocsc(), local_part(made.mass()).tocsc()


def test_programs_give_the_same_matrices():
    """Their order of dofs differs, mass and elastic eigenvalues of the free body do not."""
    every = [matrices_of(program, "Q", 2) for program in assembly.PROGRAMS]
    assert every[0][1].sum() == pytest.approx(every[1][1].sum(), rel=1e-12)
    values = [np.sort(eigsh(K, 9, M, sigma=-0.1, return_eigenvectors=False))[6:] for K, M in every]
    np.testing.assert_allclose(*values, rtol=1e-9)
    assert values[0][0] > 0.01


def given(rows, columns, **labels):
    """A result with rows of values in some columns, and the same labels in all."""
    frame = pd.DataFrame(rows, columns=columns.split()).assign(**labels)
    return SimpleNamespace(frame=lambda: frame)


def test_ratios_are_to_the_yardstick_of_the_same_round():
    """Ours takes twice as long as dolfinx in each round, however fast a round is."""
    rows = [
        (program, repeat, 2 * seconds if program == "this program" else seconds)
        for program in assembly.PROGRAMS
        for repeat, seconds in enumerate((2.0, 5.0))
    ]
    labels = {"family": "Q", "degree": 2, "elements": 3, "dofs": 9}
    made = given([(*row, row[-1]) for row in rows], "program repeat stiffness mass", **labels)
    found = assembly.times(made).set_index("program")
    assert found["ratio"].tolist() == [2.0, 1.0]
    assert found["per_element"].tolist() == pytest.approx([1e3 * 14 / 3, 1e3 * 7 / 3])


def test_methods_agree_and_projection_is_off(tmp_path, monkeypatch):
    """Three methods on the smallest mesh."""
    names = (solve.OURS, "SLEPc Krylov-Schur", "100 real modes")
    kept = {name: solve.METHODS[name] for name in names}
    monkeypatch.setattr(solve, "METHODS", kept)
    study = replace(solve.STUDY, process=None)
    solved = run(study, solve.Options(size="tiny"), tmp_path)
    assert solved.failed().empty
    found = solve.methods(solved).set_index("method")
    full, projected = found.iloc[:2], found.iloc[2]
    assert (full["worst"] < 1e-8).all()
    assert (full["backward_error"] < 1e-8).all()
    assert (found["missing"] == 0).all()
    assert full["unstable"].nunique() == 1
    assert full["unstable"].iloc[0] > 0
    assert 1e-6 < projected["worst"] < 0.1
    assert found["factorisations"].gt(0).all()
    ours = solved.frame("stages", method=solve.OURS).query("stage == 'krylov'")
    assert ours["processor"].between(0, solved.frame()["processor"].max()).all()
    assert len(ours) == 1


def test_speed_up_is_that_of_the_busiest_rank():
    labels = {"row": "ranks", "factor": 1.0, "repeat": 0, "stage": "assembly"}
    made = given([(1, 8.0, 8.0), (2, 5.0, 5.0)], "ranks processor busiest", **labels)
    assert scaling.speed_up(made)["ratio"].tolist() == pytest.approx([1.6])


def test_peak_memory_sees_an_allocation():
    with measured() as cost:
        block = np.ones(20_000_000)
        del block
    if cost.memory is None:
        pytest.skip("the system does not tell")
    assert 150 < cost.memory < 300


def test_a_run_of_calculix_that_fails_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(calculix, "PROGRAM", "false")
    with pytest.raises(ConvergenceError, match=r"no eigenvalues of part\.inp"):
        calculix.run(tmp_path / "part.inp")


@pytest.mark.slow
def test_calculix_and_this_program_find_the_same(tmp_path):
    decks.with_calculix()
    result = run(calculix.STUDY, calculix.Options(**calculix.STUDY.quick), tmp_path)
    found = calculix.differences(result).set_index("problem")
    assert (found.loc[["pad", "disc"], "this program"] < 1e-10).all()
    assert 1e-3 < found.loc["pad", "exact mass"] < 0.1
    assert found.loc["disc_pad", "this program"] < 2e-5
    growth = calculix.beside(result, "unstable")
    assert len(growth) == 1
    theirs, ours = (growth[f"growth, {name}"][0] for name in calculix.PROGRAMS[:2])
    assert ours == pytest.approx(theirs, rel=1e-3)


def test_stored_frequencies_of_calculix_are_the_same_to_rounding():
    stored = read(calculix.STUDY.name, calculix.STUDY.shipped)
    found = calculix.differences(stored).set_index("problem")
    assert (found.loc[["pad", "disc"], "this program"] < 1e-8).all()
    assert stored.frame("modes").groupby(["problem", "mesh", "program"]).size().min() >= 20
    assert (stored.frame("unstable").groupby("program").size() == 6).all()
