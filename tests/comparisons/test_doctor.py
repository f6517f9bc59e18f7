"""The doctor: what is well, what is not, and what mends it."""

import sys
from types import SimpleNamespace

import pytest

from comparisons import doctor
from comparisons.doctor import Finding


def test_what_is_installed_here_is_well(monkeypatch):
    found = [doctor.packages(), *doctor.libraries(), doctor.compiler()]
    assert [finding for finding in found if finding.mend] == []
    told = "friction-cea 0.1 has requirement numpy>=2\nother 1 requires more"
    lacking = SimpleNamespace(stdout=told, returncode=1)
    monkeypatch.setattr(doctor.subprocess, "run", lambda *_, **__: lacking)
    assert doctor.packages().mend == "python -m pip install 'friction-cea'"
    assert doctor.packages().told == told.splitlines()[0]


def test_what_does_not_load_or_fails_is_a_fault(monkeypatch):
    for missing_or_failing in ("no-such-compiler", "false"):
        monkeypatch.setenv("CC", missing_or_failing)
        assert "gcc" in doctor.compiler().mend
    monkeypatch.setattr(doctor, "LIBRARIES", {"libnone.so.1": "libnone1"})
    assert [f.mend for f in doctor.libraries()] == ["sudo apt-get install libnone1"]
    monkeypatch.setattr(doctor, "_EXACT", (1.0j, 1.5j))
    assert "wrong eigenvalues" in doctor.solve("iga").told
    monkeypatch.setattr(doctor, "_SCENE", "no_such_scene")
    assert "SceneError" in doctor.solve("iga").told


@pytest.mark.mpi
def test_the_launcher_starts_two_ranks(monkeypatch, tmp_path):
    assert doctor.launcher(launched=False).mend is None
    other = tmp_path / "mpiexec"
    other.write_text("#!/bin/sh\n")
    other.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    assert "does not start 2 ranks" in doctor.launcher(launched=False).told
    other.unlink()
    assert "no " in doctor.launcher(launched=False).told
    assert doctor.launcher(launched=True).mend is None


def test_the_solve_is_right(backend):
    assert 0 < doctor.worst_error(backend) < 1e-5


@pytest.mark.parametrize("mend", [None, "sudo apt-get install gcc"])
def test_the_code_says_whether_all_is_well(mend, monkeypatch, cea):
    found = [Finding("python", "3.12"), Finding("C compiler", "gcc", mend)]
    monkeypatch.setattr(doctor, "examine", lambda *, launched: iter(found))
    code, told, _ = cea("doctor")
    assert code == (1 if mend else 0)
    assert ("all is well" in told) == (mend is None)
    assert (f"to repair it: {mend}" in told) == (mend is not None)
