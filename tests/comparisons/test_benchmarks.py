"""`cea bench`: programs and methods that must agree do, and what is measured is what it says."""

import struct
import sys
from importlib import import_module

import decks
import numpy as np
import pandas as pd
import pytest
from mpi import mpiexec
from scipy.sparse import csr_array

from cea.errors import ConvergenceError, InputError
from comparisons.bench import assembly, calculix, ccx, contact, scaling, solve
from comparisons.bench.methods import METHODS, OURS, Problem, backward_errors
from comparisons.bench.programs import (
    EXACT_VOLUME,
    MATERIAL,
    Discretisation,
    checked,
    of_every_component,
    rigid_motions,
)
from comparisons.study.measure import measured
from comparisons.study.result import read
from comparisons.study.run import run
from scenes import run_modes

BOXES = (2, 3, 1)


def matrices_of(program, divided):
    """What the matrices of a program give."""
    found = assembly.checks(assembly.PROGRAMS[program](divided), 4)
    values = pd.DataFrame(found["values"]).groupby("what")["value"].apply(np.array)
    return found["checks"][0], values["inertia"], values["eigenvalues"]


@pytest.mark.grid(quick=1)
@pytest.mark.parametrize("family", ["Q", "P"])
@pytest.mark.parametrize("program", list(assembly.PROGRAMS)[1:])
def test_programs_give_the_same_matrices(program, family):
    divided = Discretisation(family, 2, BOXES)
    theirs, inertia, eigenvalues = matrices_of(program, divided)
    _, right, exact = matrices_of(assembly.OURS, divided)
    np.testing.assert_allclose(inertia, right, rtol=1e-12)
    np.testing.assert_allclose(eigenvalues, exact, rtol=1e-11)
    assert theirs["rigid"] < 1e-12
    assert theirs["asymmetry"] < 1e-14


@pytest.mark.parametrize(("family", "degree"), [("Q", 1), ("P", 3), ("NURBS", 3)])
def test_a_free_body_has_its_mass_and_no_force_in_rigid_motion(family, degree):
    found, inertia, eigenvalues = matrices_of(assembly.OURS, Discretisation(family, degree, BOXES))
    assert found["rigid"] < 1e-12
    assert found["asymmetry"] == 0
    mass, *others = inertia[:3]
    assert others == pytest.approx([mass, mass], rel=1e-13)
    if family == "NURBS":  # Gauss points integrate the rational Jacobian nearly
        assert mass / MATERIAL.rho == pytest.approx(EXACT_VOLUME, rel=1e-4)
    else:
        chords = np.sin(np.pi / 6) / (np.pi / 6)  # three straight edges round a quarter
        assert mass / MATERIAL.rho == pytest.approx(chords * EXACT_VOLUME, rel=1e-13)
    assert min(eigenvalues) > 0.01


def test_wrong_matrices_are_seen():
    points = np.random.default_rng(0).random((4, 3))
    K = np.diag(np.arange(1.0, 13.0))
    K[0, 1] = 2.0
    seen = checked(csr_array(K), csr_array(np.eye(12)), rigid_motions(points), 2)
    assert seen["rigid"] > 0.05
    assert seen["asymmetry"] == pytest.approx(2 / 12)


def test_the_mass_of_one_component_stands_for_all():
    M = csr_array(np.array([[2.0, 1.0], [1.0, 3.0]]))
    whole = of_every_component(M, 6).toarray()
    assert np.array_equal(whole[::3, ::3], M.toarray())
    assert np.array_equal(whole[2::3, 2::3], M.toarray())
    assert not whole[::3, 1::3].any()
    assert of_every_component(M, 2) is M


def test_ratios_are_to_the_yardstick_of_the_same_round(tmp_path, monkeypatch):
    """Ours takes twice as long as dolfinx in each round, however fast a round is."""
    taken = {(assembly.OURS, 0): 4.0, (assembly.PLAIN, 0): 2.0}
    taken |= {(assembly.OURS, 1): 10.0, (assembly.PLAIN, 1): 5.0}

    class Given:
        def frame(self, table="runs"):
            row = {"functions": "Q2", "family": "Q", "degree": 2, "elements": 3, "dofs": 9}
            return pd.DataFrame(
                [
                    {"functions": "Q2", "program": program, "repeat": repeat}
                    | row
                    | {"stiffness": s, "mass": s, "memory": 1.0, "finished": 1.0}
                    for (program, repeat), s in taken.items()
                ]
            )

    found = assembly.times(Given()).set_index("program")
    assert found["ratio"].tolist() == [2.0, 1.0]
    assert found["per_element"].tolist() == pytest.approx([1e3 * 14 / 3, 1e3 * 7 / 3])


def test_degree_4_has_a_coarser_body():
    options = assembly.Options(boxes=(4, 4, 2), boxes_of_degree_4=(2, 2, 1))
    found = [assembly.discretisation(name, options).boxes for name in ("Q3", "Q4", "NURBS4")]
    assert found == [(4, 4, 2), (2, 2, 1), (4, 4, 2)]


@pytest.mark.parametrize("method", ["gpts", "mortar"])
def test_every_stage_of_a_contact_is_timed(backend, method):
    rule = {"method": method} | ({"points": 2} if method == "gpts" else {})
    cost = contact.contact_cost(contact.blocks(backend, 10, rule))
    assert cost.pop("points") >= {"gpts": 4 * 10**2, "mortar": 9 * 18**2}[method]
    assert all(seconds > 0 for seconds in cost.values())


@pytest.mark.slow
def test_time_of_a_contact_is_linear_in_points(backend):
    """Ten times the points take less than twenty times the time: squared it would be a hundred."""
    few, many = (
        contact.contact_cost(contact.blocks(backend, n, {"method": "gpts", "points": 4}))
        for n in (40, 126)
    )
    assert 9.5 < many["points"] / few["points"] < 10.5
    for stage in ("rule", "search", "assembly"):
        assert many[stage] < 20 * max(few[stage], 0.02), stage


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """Three methods on the smallest mesh, in processes of their own."""
    only = {"size": "tiny", "repeats": 2}
    kept = {name: METHODS[name] for name in (OURS, "SLEPc Krylov-Schur", "100 real modes")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solve, "METHODS", kept)
        return run(solve.STUDY, solve.Options(**only), tmp_path_factory.mktemp("solve"))


def test_methods_agree_and_projection_is_off(solved):
    assert solved.failed().empty
    found = solve.methods(solved).set_index("method")
    full, projected = found.iloc[:2], found.iloc[2]
    assert (full["worst"] < 1e-8).all()
    assert (full["backward"] < 1e-8).all()
    assert (found["missing"] == 0).all()
    assert full["unstable"].nunique() == 1
    assert full["unstable"].iloc[0] > 0
    assert 1e-6 < projected["worst"] < 0.1
    assert solve.tightest(solved) in full.index
    assert (found["factorisations"] >= 1).all()
    own = run_modes(solve.scene({}, solve.Options("tiny")))
    assert (found["eigenvalues"] == len(own.eigenvalues)).all()


def test_errors_are_those_of_pairs():
    exact = np.array([1.0, 2.0, 4.0]) + 0j
    errors, missing = solve.errors_of(np.array([4.4, 1.0 + 0j]), exact)
    assert sorted(errors) == pytest.approx([0, 0.1])
    assert missing == 1


def test_a_complex_pair_has_one_mode_that_grows():
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


def test_speed_up_and_growth_are_those_of_the_seconds():
    """Eight times the unknowns, eight times the assembly, 64 times the factorisation."""

    def rows(row, ranks, unknowns, seconds):
        labels = {"row": row, "backend": "fe", "degree": 2, "factor": 1.0 * unknowns}
        labels |= {"ranks": ranks, "repeat": 0}
        stages = {"assembly": seconds, "factorisation": seconds**2, "whole": seconds + seconds**2}
        measured = {"unknowns": unknowns, "modes": 1, "clock": 1.0, "memory": 1.0}
        return [
            labels | {"stage": stage, "processor": s, "busiest": s} | measured
            for stage, s in stages.items()
        ]

    class Given:
        def frame(self, table="runs"):
            every = [("size", 1, 1000, 1.0), ("size", 1, 8000, 8.0), ("strong", 1, 8000, 8.0)]
            every += [("strong", 2, 8000, 5.0), ("weak", 1, 1000, 1.0), ("weak", 2, 1000, 1.25)]
            return pd.DataFrame([row for each in every for row in rows(*each)])

    powers = scaling.growth(Given()).set_index("stage")["power"]
    assert powers["assembly"] == pytest.approx(1.0)
    assert powers["factorisation"] == pytest.approx(2.0)
    ratios = scaling.speed_up(Given()).set_index(["row", "stage"])["ratio"]
    assert ratios["strong", "assembly"] == pytest.approx(1.6)
    assert ratios["weak", "assembly"] == pytest.approx(0.8)


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
     E I G E N V A L U E   O U T P U T

 MODE NO    EIGENVALUE                       FREQUENCY
                                     REAL PART            IMAGINARY PART
                           (RAD/TIME)      (CYCLES/TIME     (RAD/TIME)

      1   0.4000000E+01   0.2000000E+01   0.3183099E+00   0.0000000E+00
      2   0.9000000E+01   0.3000000E+01   0.4774648E+00   0.0000000E+00

     P A R T I C I P A T I O N   F A C T O R S

      1   0.1000000E+01   0.2000000E+01   0.3000000E+01   0.4000000E+01
"""
COMPLEX = """
     area,  normal force (+ = tension) and shear force (size)

     3.978058E-03 -2.999806E-03  2.059536E-03

 MODE NO                     FREQUENCY
                      REAL PART         IMAGINARY PART
             (RAD/TIME)   (CYCLES/TIME)   (RAD/TIME)

      1   0.5000000E+01   0.7957747E+00  -0.2500000E+00
      2   0.5000000E+01   0.7957747E+00   0.2500000E+00
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A program in the place of CalculiX, which leaves what it is given as results."""

    def install(listed, *, perturbed, kappa=(4.0, 9.0), said="Total CalculiX Time: 1.500000"):
        stored = struct.pack(f"=4i{len(kappa)}d", 0, 1, perturbed, len(kappa), *kappa)
        (tmp_path / "given.dat").write_text(listed)
        (tmp_path / "given.eig").write_bytes(stored)
        program = tmp_path / "ccx"
        program.write_text(
            f'#!/bin/sh\nfor e in dat eig; do cp given.$e $1.$e; done\necho "{said}"\n'
        )
        program.chmod(0o755)
        monkeypatch.setattr(ccx, "program", lambda: str(program))
        deck = tmp_path / "part.inp"
        deck.touch()
        return ccx.run(deck)

    return install


def test_real_eigenvalues_are_read_with_all_their_digits(installed):
    kappa = (4.000000000001, 9.0)
    found = installed(REAL, perturbed=0, kappa=kappa)
    assert found.eigenvalues == pytest.approx(1j * np.sqrt(kappa), rel=1e-15)
    assert found.seconds == 1.5
    assert found.area is None


def test_complex_eigenvalues_are_read_from_the_list_with_both_growth_rates(installed):
    found = installed(COMPLEX, perturbed=1)
    assert found.eigenvalues.tolist() == [-0.25 + 5j, 0.25 + 5j]
    assert found.area == 3.978058e-3


@pytest.mark.parametrize("said", [" *ERROR in arpack", "nothing"])
def test_a_run_of_calculix_without_results_is_told(installed, said):
    with pytest.raises(ConvergenceError, match="no eigenvalues"):
        installed("" if said == "nothing" else REAL, perturbed=0, said=said)


def test_a_missing_calculix_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="calculix-ccx"):
        ccx.program()


def test_processes_are_measured_one_by_one(tmp_path):
    held = bytearray(3 * 10**8)  # what this process holds is not theirs
    code = "import time; time.sleep(0.1); print('done')"
    small = ccx.run_measured([sys.executable, "-c", code], tmp_path, "log")
    code = "import time; x = bytearray(2 * 10**8); time.sleep(0.3)"
    large = ccx.run_measured([sys.executable, "-c", code], tmp_path, "log")
    assert small.output == "done\n"
    assert 0 < small.memory < 5e7
    assert 2e8 < large.memory < 2.5e8 < len(held)
    assert large.clock > 0.3 > large.processor / 2
    with pytest.raises(ConvergenceError, match="code 3"):
        ccx.run_measured([sys.executable, "-c", "raise SystemExit(3)"], tmp_path, "log")


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
        ("assembly", {"modes": 0}, "modes"),
        ("contact", {"elements": (0,)}, "elements"),
        ("solve", {"size": "huge"}, "size"),
        ("solve", {"ranks": 0}, "ranks"),
        ("solve", {"memory": 0.0}, "memory"),
        ("scaling", {"size": "huge"}, "size"),
        ("scaling", {"ranks": ()}, "ranks"),
        ("matrices", {"repeats": 0}, "repeats"),
    ],
)
def test_wrong_options_are_refused(name, change, field):
    with pytest.raises(InputError) as caught:
        import_module(f"comparisons.bench.{name}").Options(**change)
    assert caught.value.field == field
