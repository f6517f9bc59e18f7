"""The doctor: what is well, what is not, and what mends it."""

import sys

import pytest

from comparisons.cli.app import main
from comparisons.doctor import packages, solves, study, system
from comparisons.doctor.finding import Finding


@pytest.mark.parametrize(
    ("found", "bounds", "fits"),
    [
        ("0.11.0.post0", ">=0.11,<0.12", True),
        ("0.12.0", ">=0.11,<0.12", False),
        ("0.9", ">=0.11,<0.12", False),
        ("4.1.2", ">=4", True),
        ("10.0", ">=9.5", True),
        ("2.8", ">=2.8.0", True),
        ("2.8rc1", ">=2.9", False),
        ("1.0", "", True),
    ],
)
def test_versions_are_compared_as_numbers(found, bounds, fits):
    assert packages.suits(found, bounds) == fits


def test_what_is_installed_here_is_well():
    found = {finding.name: finding for finding in packages.packages()}
    assert all(finding.well for finding in found.values())
    assert {"friction-cea", "numpy", "pydantic", "gmsh", "pyvista (extra pictures)"} <= found.keys()
    assert not any("ruff" in name for name in found)


def test_packages_that_lack_or_are_too_old_are_faults():
    missing = packages.package("no-such-package", ">=1")
    assert not missing.well
    assert missing.mend == "python -m pip install 'friction-cea'"
    extra = packages.package("no-such-package", ">=1", "pictures")
    assert extra.well
    assert "friction-cea[pictures]" in extra.told
    old = packages.package("numpy", ">=1000")
    assert old.mend == "python -m pip install 'numpy>=1000'"


def test_a_compiler_that_is_not_there_or_fails_is_a_fault(monkeypatch):
    assert system.compiler().well
    monkeypatch.setenv("CC", "no-such-compiler")
    assert "gcc" in system.compiler().mend
    monkeypatch.setenv("CC", "false")
    assert not system.compiler().well


def test_libraries_that_do_not_load_are_faults(monkeypatch):
    assert all(finding.well for finding in system.libraries())
    monkeypatch.setattr(system, "LIBRARIES", {"libnone.so.1": "libnone1"})
    (finding,) = system.libraries()
    assert finding.mend == "sudo apt-get install libnone1"


@pytest.mark.mpi
def test_the_launcher_starts_two_ranks(monkeypatch, tmp_path):
    assert system.launcher(launched=False).well
    other = tmp_path / "mpiexec"
    other.write_text("#!/bin/sh\n")
    other.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    finding = system.launcher(launched=False)
    assert "does not start 2 ranks" in finding.told
    other.unlink()
    assert "no " in system.launcher(launched=False).told
    assert system.launcher(launched=True).well


def test_the_solve_is_right(backend):
    finding = solves.solve(backend)
    assert finding.well
    assert 0 < solves.worst_error(backend) < 1e-5


def test_a_solve_that_fails_or_is_wrong_is_a_fault(monkeypatch):
    monkeypatch.setattr(solves, "_EXACT", (1.0j, 1.5j))
    assert "wrong eigenvalues" in solves.solve("iga").told
    monkeypatch.setattr(solves, "_SCENE", "no_such_scene")
    assert "SceneError" in solves.solve("iga").told


def test_nothing_more_is_tried_where_packages_lack(monkeypatch):
    fault = Finding("numpy", "not installed", "python -m pip install 'friction-cea'")
    monkeypatch.setattr(study, "packages", lambda: iter([fault]))
    found = list(study.examine(launched=True))
    assert fault in found
    assert not any(finding.name.startswith("solve") for finding in found)


@pytest.mark.parametrize("mend", [None, "sudo apt-get install gcc"])
def test_the_code_says_whether_all_is_well(mend, monkeypatch, capsys):
    found = [Finding("python", "3.12"), Finding("C compiler", "gcc", mend)]
    monkeypatch.setattr(study, "examine", lambda *, launched: iter(found))
    monkeypatch.setattr(sys, "argv", ["cea", "doctor"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == (0 if mend is None else 1)
    told = capsys.readouterr().out
    assert ("all is well" in told) == (mend is None)
    assert ("mend it: sudo apt-get install gcc" in told) == (mend is not None)
