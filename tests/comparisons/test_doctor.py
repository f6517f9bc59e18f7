"""The doctor: what is well, what is not, and what mends it."""

import sys

import pytest

from comparisons import doctor
from comparisons.doctor import Finding


def test_what_is_installed_here_is_well():
    found = {finding.name: finding for finding in doctor.packages()}
    assert not any(finding.mend for finding in found.values())
    assert {"friction-cea", "numpy", "pydantic", "gmsh", "pyvista (extra pictures)"} <= found.keys()
    assert not any("ruff" in name for name in found)


def test_packages_that_lack_or_are_too_old_are_faults():
    missing = doctor.package("no-such-package>=1")
    assert missing.mend == "python -m pip install 'friction-cea'"
    extra = doctor.package("no-such-package>=1; extra == 'pictures'")
    assert extra.mend is None
    assert "friction-cea[pictures]" in extra.told
    old = doctor.package("numpy>=1000")
    assert old.mend == "python -m pip install 'numpy>=1000'"
    assert doctor.package("numpy>=1,<1000").mend is None


def test_a_compiler_that_is_not_there_or_fails_is_a_fault(monkeypatch):
    assert doctor.compiler().mend is None
    for missing_or_failing in ("no-such-compiler", "false"):
        monkeypatch.setenv("CC", missing_or_failing)
        assert "gcc" in doctor.compiler().mend


def test_libraries_that_do_not_load_are_faults(monkeypatch):
    assert all(finding.mend is None for finding in doctor.libraries())
    monkeypatch.setattr(doctor, "LIBRARIES", {"libnone.so.1": "libnone1"})
    (finding,) = doctor.libraries()
    assert finding.mend == "sudo apt-get install libnone1"


@pytest.mark.mpi
def test_the_launcher_starts_two_ranks(monkeypatch, tmp_path):
    assert doctor.launcher(launched=False).mend is None
    other = tmp_path / "mpiexec"
    other.write_text("#!/bin/sh\n")
    other.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    finding = doctor.launcher(launched=False)
    assert "does not start 2 ranks" in finding.told
    other.unlink()
    assert "no " in doctor.launcher(launched=False).told
    assert doctor.launcher(launched=True).mend is None


def test_the_solve_is_right(backend):
    finding = doctor.solve(backend)
    assert finding.mend is None
    assert 0 < doctor.worst_error(backend) < 1e-5


def test_a_solve_that_fails_or_is_wrong_is_a_fault(monkeypatch):
    monkeypatch.setattr(doctor, "_EXACT", (1.0j, 1.5j))
    assert "wrong eigenvalues" in doctor.solve("iga").told
    monkeypatch.setattr(doctor, "_SCENE", "no_such_scene")
    assert "SceneError" in doctor.solve("iga").told


@pytest.mark.parametrize("mend", [None, "sudo apt-get install gcc"])
def test_the_code_says_whether_all_is_well(mend, monkeypatch, cea):
    found = [Finding("python", "3.12"), Finding("C compiler", "gcc", mend)]
    monkeypatch.setattr(doctor, "examine", lambda *, launched: iter(found))
    code, told, _ = cea("doctor")
    assert code == (0 if mend is None else 1)
    assert ("all is well" in told) == (mend is None)
    assert ("mend it: sudo apt-get install gcc" in told) == (mend is not None)
