"""The doctor: what is well, what is not, and what mends it."""

import sys
from types import SimpleNamespace

import pytest

from comparisons import doctor
from comparisons.doctor import Finding


def test_what_is_installed_here_is_well(monkeypatch):
    assert [finding for finding in doctor.examine(launched=True) if finding.mend] == []
    told = "friction-cea 0.1 has requirement numpy>=2\nother 1 requires more"
    monkeypatch.setattr(doctor.subprocess, "run", lambda *_, **__: SimpleNamespace(stdout=told))
    *_, last = doctor.examine(launched=True)
    assert last.told == f"RuntimeError: {told.splitlines()[0]}"
    assert last.mend == "python -m pip install 'friction-cea'"


def test_what_does_not_load_or_fails_is_a_fault(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setattr(doctor, "_EXACT", (1.0j, 1.5j))
    with pytest.raises(FileNotFoundError):
        doctor.compiler()
    with pytest.raises(RuntimeError, match="wrong eigenvalues"):
        doctor.solve("iga")
    monkeypatch.setenv("CC", "false")
    monkeypatch.setattr(doctor, "packages", lambda: "as needed")
    monkeypatch.setattr(doctor, "LIBRARIES", {"libnone.so.1": "libnone1"})
    monkeypatch.setattr(doctor, "_SCENE", "no_such_scene")
    found = {finding.name: finding for finding in doctor.examine(launched=True)}
    assert "gcc" in found["C compiler"].mend
    assert found["libnone.so.1"].mend == "sudo apt-get install libnone1"
    assert "SceneError" in found["solve on iga"].told


@pytest.mark.mpi
def test_the_launcher_starts_two_ranks(monkeypatch, tmp_path):
    assert "starts 2 ranks" in doctor.launcher()
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(FileNotFoundError):
        doctor.launcher()


@pytest.mark.parametrize("mend", [None, "sudo apt-get install gcc"])
def test_the_code_says_whether_all_is_well(mend, monkeypatch, cea):
    found = [Finding("packages", "as needed"), Finding("C compiler", "gcc", mend)]
    monkeypatch.setattr(doctor, "examine", lambda *, launched: iter(found))
    code, told, _ = cea("doctor")
    assert code == (1 if mend else 0)
    assert ("all is well" in told) == (mend is None)
    assert (f"to repair it: {mend}" in told) == (mend is not None)
