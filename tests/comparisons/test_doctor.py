"""The doctor: what is well, what is not, and what mends it."""

import sys

import pytest

from comparisons import doctor
from comparisons.doctor import Finding


def test_what_is_installed_here_is_well():
    found = {finding.name: finding for finding in doctor.packages()}
    every = [*found.values(), *doctor.libraries(), doctor.compiler()]
    assert [finding for finding in every if finding.mend] == []
    assert {"friction-cea", "numpy", "pydantic", "gmsh", "pyvista (extra pictures)"} <= found.keys()
    assert not any("ruff" in name for name in found)


@pytest.mark.parametrize(
    ("requirement", "mend", "told"),
    [
        ("no-such-package>=1", "python -m pip install 'friction-cea'", ""),
        ("no-such-package>=1; extra == 'pictures'", None, "friction-cea[pictures]"),
        ("numpy>=1000", "python -m pip install 'numpy>=1000'", ""),
        ("numpy>=1,<1000", None, ""),
    ],
)
def test_packages_that_lack_or_are_too_old_are_faults(requirement, mend, told):
    finding = doctor.package(requirement)
    assert finding.mend == mend
    assert told in finding.told


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


def test_the_solve_is_right(backend, monkeypatch):
    error = doctor.worst_error(backend)
    assert 0 < error < 1e-5
    monkeypatch.setattr(doctor, "worst_error", lambda backend: error)
    assert doctor.solve(backend).mend is None


@pytest.mark.parametrize("mend", [None, "sudo apt-get install gcc"])
def test_the_code_says_whether_all_is_well(mend, monkeypatch, cea):
    found = [Finding("python", "3.12"), Finding("C compiler", "gcc", mend)]
    monkeypatch.setattr(doctor, "examine", lambda *, launched: iter(found))
    code, told, _ = cea("doctor")
    assert code == (1 if mend else 0)
    assert ("all is well" in told) == (mend is None)
    assert (f"mend it: {mend}" in told) == (mend is not None)
