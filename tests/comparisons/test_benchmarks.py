"""`cea bench`: programs and methods that must agree do, and what is measured is what it says."""

import struct
import sys
from importlib import import_module

import decks
import numpy as np
import pandas as pd
import pytest
from mpi import mpiexec
from scipy.sparse.linalg import eigsh

from cea.errors import ConvergenceError, InputError
from cea.matrices import local_part
from comparisons.bench import assembly, calculix, ccx, scaling, solve
from comparisons.bench.methods import METHODS, OURS, Problem, backward_errors
from comparisons.bench.programs import EXACT_VOLUME, MATERIAL, Discretisation
from comparisons.study.measure import measured
from comparisons.study.result import read
from comparisons.study.run import run
from scenes import run_modes

BOXES = (2, 3, 1)


def matrices_of(program, family, degree):
    """Stiffness and mass, scipy."""
    made = assembly.PROGRAMS[program](Discretisation(family, degree, BOXES))
    return local_part(made.stiffness()).tocsc(), local_part(made.mass()).tocsc()


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("family", ["Q", "P"])
def test_programs_give_the_same_matrices(family):
    """Their order of dofs differs, mass and elastic eigenvalues of the free body do not."""
    every = [matrices_of(program, family, 2) for program in assembly.PROGRAMS]
    masses = [M.sum() for _, M in every]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)
    values = [np.sort(eigsh(K, 9, M, sigma=-0.1, return_eigenvectors=False))[6:] for K, M in every]
    np.testing.assert_allclose(*values, rtol=1e-9)
    assert values[0][0] > 0.01


@pytest.mark.parametrize(("family", "degree"), [("Q", 1), ("P", 3), ("NURBS", 3)])
def test_a_free_body_has_its_mass_and_no_force_in_translation(family, degree):
    K, M = matrices_of(assembly.OURS, family, degree)
    assert abs(K.reshape((-1, 3)).sum(axis=0)).max() < 1e-10
    assert abs(K - K.T).max() == 0
    volume = M.sum() / 3 / MATERIAL.rho
    if family == "NURBS":  # Gauss points integrate the rational Jacobian nearly
        assert volume == pytest.approx(EXACT_VOLUME, rel=1e-4)
    else:
        chords = np.sin(np.pi / 6) / (np.pi / 6)  # three straight edges round a quarter
        assert volume == pytest.approx(chords * EXACT_VOLUME, rel=1e-12)


class Given:
    """A result with these rows."""

    def __init__(self, rows):
        self.rows = rows

    def frame(self, table="runs"):
        """Its rows."""
        return pd.DataFrame(self.rows)


def test_ratios_are_to_the_yardstick_of_the_same_round():
    """Ours takes twice as long as dolfinx in each round, however fast a round is."""
    taken = {(assembly.OURS, 0): 4.0, (assembly.PLAIN, 0): 2.0}
    taken |= {(assembly.OURS, 1): 10.0, (assembly.PLAIN, 1): 5.0}
    row = {"family": "Q", "degree": 2, "elements": 3, "dofs": 9, "memory": 1.0, "finished": 1.0}
    rows = [
        {"functions": "Q2", "program": program, "repeat": repeat, "stiffness": s, "mass": s} | row
        for (program, repeat), s in taken.items()
    ]
    found = assembly.times(Given(rows)).set_index("program")
    assert found["ratio"].tolist() == [2.0, 1.0]
    assert found["per_element"].tolist() == pytest.approx([1e3 * 14 / 3, 1e3 * 7 / 3])


def test_methods_agree_and_projection_is_off(tmp_path, monkeypatch):
    """Three methods on the smallest mesh, in processes of their own."""
    kept = {name: METHODS[name] for name in (OURS, "SLEPc Krylov-Schur", "100 real modes")}
    monkeypatch.setattr(solve, "METHODS", kept)
    solved = run(solve.STUDY, solve.Options(size="tiny", repeats=2), tmp_path)
    assert solved.failed().empty
    found = solve.methods(solved).set_index("method")
    full, projected = found.iloc[:2], found.iloc[2]
    assert (full["worst"] < 1e-8).all()
    assert (full["backward_error"] < 1e-8).all()
    assert (found["missing"] == 0).all()
    assert full["unstable"].nunique() == 1
    assert full["unstable"].iloc[0] > 0
    assert 1e-6 < projected["worst"] < 0.1
    assert solve.tightest(solved) in full.index
    own = run_modes(solve.scene({}, solve.Options("tiny")))
    assert (found["eigenvalues"] == len(own.eigenvalues)).all()


def test_errors_are_those_of_pairs():
    exact = np.array([1.0, 2.0, 4.0]) + 0j
    errors, missing = solve.errors_of(np.array([4.4, 1.0 + 0j]), exact)
    assert sorted(errors) == pytest.approx([0, 0.1])
    assert missing == 1
    pair = -((np.array([1e3j + 1, 1e3j - 1])) ** 2)
    assert solve.unstable(np.append(pair, 1e6)) == 1


ON_RANKS = """
from comparisons.bench.methods import METHODS, Problem, backward_errors
from comparisons.bench.solve import Options, scene
problem = Problem.of(scene({}, Options("tiny")))
for method in list(METHODS.values())[:2]:
    found = method(problem, 70).inside(problem.top)
    assert len(found.kappa) == 70, len(found.kappa)
    assert backward_errors(problem, found).max() < 1e-8
"""


@pytest.mark.slow
@pytest.mark.mpi
def test_methods_find_the_same_on_two_ranks():
    done = mpiexec(2, sys.executable, "-c", ON_RANKS)
    assert done.returncode == 0, done.stderr


def test_backward_errors_see_a_wrong_eigenvalue():
    problem = Problem.of(solve.scene({}, solve.Options("tiny")))
    found = METHODS[OURS](problem, 0)
    assert backward_errors(problem, found).max() < 1e-8
    worse = type(found)(1.001 * found.kappa, found.vectors)
    assert backward_errors(problem, worse).min() == pytest.approx(1e-3, rel=0.01)


def test_speed_up_is_that_of_the_busiest_rank():
    rows = [
        {"row": row, "backend": "fe", "degree": 2, "factor": 1.0, "ranks": ranks, "repeat": 0}
        | {"stage": "assembly", "processor": seconds, "busiest": seconds}
        for row, ranks, seconds in (
            *(("strong", 1, 8.0), ("strong", 2, 5.0), ("weak", 1, 1.0), ("weak", 2, 1.25)),
        )
    ]
    assert scaling.speed_up(Given(rows))["ratio"].tolist() == pytest.approx([1.6, 0.8])


def test_weak_scaling_keeps_the_unknowns_of_a_rank():
    cases = [c for c in scaling.cases(scaling.Options("tiny", (1, 2))) if c["row"] == "weak"]
    one, two = (scaling.scene(case, None).bodies["disc"].mesh.fe.elements for case in cases)
    assert (two[0], two[1], two[2]) == (one[0], 2 * one[1], one[2])


def test_peak_memory_sees_an_allocation():
    with measured() as cost:
        block = np.ones(20_000_000)
        del block
    if cost.memory is None:
        pytest.skip("the system does not tell")
    assert 150 < cost.memory < 300
    with measured() as cost:
        pass
    assert cost.memory < 50


REAL = """
 MODE NO    EIGENVALUE                       FREQUENCY
      1   0.4000000E+01   0.2000000E+01   0.3183099E+00   0.0000000E+00
      2   0.9000000E+01   0.3000000E+01   0.4774648E+00   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S

      1   0.1000000E+01   0.2000000E+01   0.3000000E+01   0.4000000E+01
"""
COMPLEX = """
      1   0.5000000E+01   0.7957747E+00  -0.2500000E+00
      2   0.5000000E+01   0.7957747E+00   0.2500000E+00
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A program in the place of CalculiX, which leaves what it is given as results."""

    def install(listed, *, perturbed, kappa=(4.0, 9.0), said="done"):
        stored = struct.pack(f"=4i{len(kappa)}d", 0, 1, perturbed, len(kappa), *kappa)
        (tmp_path / "given.dat").write_text(listed)
        (tmp_path / "given.eig").write_bytes(stored)
        program = tmp_path / "ccx"
        program.write_text(
            f'#!/bin/sh\nfor e in dat eig; do cp given.$e $1.$e; done\necho "{said}"\n'
        )
        program.chmod(0o755)
        monkeypatch.setattr(ccx, "program", lambda: str(program))
        return ccx.run(tmp_path / "part.inp")

    return install


def test_eigenvalues_of_calculix_are_read_with_the_digits_it_gives(installed):
    kappa = (4.000000000001, 9.0)
    real = installed(REAL, perturbed=0, kappa=kappa)
    assert real.eigenvalues == pytest.approx(1j * np.sqrt(kappa), rel=1e-15)
    assert installed(COMPLEX, perturbed=1).eigenvalues.tolist() == [-0.25 + 5j, 0.25 + 5j]


@pytest.mark.parametrize("said", [" *ERROR in arpack", "nothing"])
def test_a_run_of_calculix_without_results_is_told(installed, said):
    with pytest.raises(ConvergenceError, match="no eigenvalues"):
        installed("" if said == "nothing" else REAL, perturbed=0, said=said)


def test_a_missing_calculix_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="calculix-ccx"):
        ccx.program()


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
    assert "6 unstable modes, this program 6" in calculix.headline(stored)


@pytest.mark.parametrize(
    ("name", "change", "field"),
    [
        ("assembly", {"repeats": 0}, "repeats"),
        ("assembly", {"boxes": (0, 1, 1)}, "boxes"),
        ("solve", {"size": "huge"}, "size"),
        ("solve", {"memory": 0.0}, "memory"),
        ("scaling", {"ranks": ()}, "ranks"),
        ("matrices", {"repeats": 0}, "repeats"),
    ],
)
def test_wrong_options_are_refused(name, change, field):
    with pytest.raises(InputError) as caught:
        import_module(f"comparisons.bench.{name}").Options(**change)
    assert caught.value.field == field
