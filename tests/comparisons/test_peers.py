"""CalculiX beside this program: its files read, runs measured, the study, its stored numbers."""

import json
import struct
import sys
from dataclasses import replace

import decks
import numpy as np
import pytest

from cea.errors import ConvergenceError, InputError
from comparisons.cli.app import main
from comparisons.kit.progress import Progress
from comparisons.peers import calculix, study, words
from comparisons.peers.measured import run_measured
from comparisons.peers.page import read_peers, tables_of, write_peers
from comparisons.peers.study import QUICK, STORED, compared, exported, run_peers
from comparisons.peers.tables import apart
from scenes import load_scene

QUIET = Progress(step=lambda name: None, stage=lambda stage: None)
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
        monkeypatch.setattr(calculix, "program", lambda: str(program))
        deck = tmp_path / "part.inp"
        deck.touch()
        return calculix.run(deck)

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
def test_a_run_without_results_is_told(installed, said):
    with pytest.raises(ConvergenceError, match="no eigenvalues"):
        installed("" if said == "nothing" else REAL, perturbed=0, said=said)


def test_a_missing_program_is_told(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="calculix-ccx"):
        calculix.program()
    monkeypatch.setattr(
        sys, "argv", ["cea", "bench", "calculix", "--recompute", "--out", str(tmp_path / "o")]
    )
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    assert "program = 'ccx'" in capsys.readouterr().err


def test_processes_are_measured_one_by_one(tmp_path):
    held = bytearray(3 * 10**8)  # what this process holds is not theirs
    code = "import time; time.sleep(0.1); print('done')"
    small = run_measured([sys.executable, "-c", code], tmp_path, "log")
    code = "import time; x = bytearray(2 * 10**8); time.sleep(0.3)"
    large = run_measured([sys.executable, "-c", code], tmp_path, "log")
    assert small.output == "done\n"
    assert 0 < small.memory < 5e7
    assert 2e8 < large.memory < 2.5e8 < len(held)
    assert large.clock > 0.3 > large.processor / 2
    with pytest.raises(ConvergenceError, match="code 3"):
        run_measured([sys.executable, "-c", "raise SystemExit(3)"], tmp_path, "log")


@pytest.mark.slow
def test_each_body_alone_has_the_frequencies_of_calculix():
    decks.with_calculix()
    whole = exported(load_scene("disc_pad", backend="fe"), QUICK.meshes[0])
    pad = replace(whole, name="pad", bodies={"pad": whole.bodies["pad"]}, contacts={})
    found = compared(pad, 1, QUIET)
    assert len(found["modes"]) == study.MODES
    assert apart(found) < 1e-10
    assert 1e-3 < apart(found, "exact_mass") < 0.1


@pytest.fixture(scope="module")
def measured():
    decks.with_calculix()
    return run_peers(QUICK, QUIET)


@pytest.mark.slow
def test_both_find_the_same(measured, tmp_path):
    alone = [p for p in measured["problems"] if not p["contact"]]
    (touching,) = [p for p in measured["problems"] if p["contact"]]
    assert max(map(apart, alone)) < 1e-10
    assert apart(touching) < 2e-5
    (theirs,), (ours,) = (touching["unstable"][name] for name in ("CalculiX", "this program"))
    assert ours["growth"] == pytest.approx(theirs["growth"], rel=1e-3)
    page = write_peers(measured, tmp_path)
    assert read_peers(tmp_path)["problems"] == json.loads(json.dumps(measured["problems"]))
    assert words.summary(measured) in page.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def stored():
    return read_peers(STORED)


def test_stored_frequencies_are_the_same_to_rounding(stored):
    alone = [p for p in stored["problems"] if not p["contact"]]
    assert {p["name"] for p in alone} == {"disc", "pad"}
    assert all(len(p["modes"]) >= 20 for p in alone)
    assert max(map(apart, alone)) < 1e-8


def test_stored_tables_are_those_of_the_record(stored):
    for table in tables_of(stored):
        if table.name != "machine":
            lines = (STORED / f"{table.name}.csv").read_text(encoding="utf-8").splitlines()
            assert lines[0].split(",") == [column.name for column in table.columns]
            assert len(lines) == len(table.rows) + 1
            assert lines[-1].split(",")[0] == table.rows[-1][0].split(",")[0].join(['"', ""])


def test_words_follow_the_data(stored):
    summary = words.summary(stored)
    assert "unstable modes" in summary
    data = json.loads(json.dumps(stored))
    for problem in data["problems"]:
        problem["unstable"]["this program"] = problem["unstable"]["this program"][1:]
    assert "different numbers of unstable modes" in words.summary(data)
    for problem in data["problems"]:
        problem["unstable"] = {name: [] for name in problem["unstable"]}
    assert "no mode is unstable" in words.summary(data)
    data["problems"][0]["modes"][0]["ours"] *= 1.5
    assert "differ by 0.5" in words.summary(data)


def test_the_command_shows_what_is_stored(tmp_path, monkeypatch, capsys, stored):
    monkeypatch.setattr(sys, "argv", ["cea", "bench", "calculix", "--out", str(tmp_path)])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    assert words.summary(stored)[:40] in capsys.readouterr().out
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert words.STICKING.replace("'", "&#39;") in page
