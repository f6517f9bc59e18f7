"""The command line as a person meets it."""

import json
import subprocess
import sys

import pytest

QUICK = [
    "bodies.disc.mesh.iga={degree=[2,2,2],elements=[3,8,1]}",
    "bodies.disc.mesh.fe={degree=1,elements=[3,12,1]}",
    "analysis.max_frequency=4000.0",
]


def with_settings(settings):
    return [part for setting in settings for part in ("--set", setting)]


@pytest.mark.grid(quick=1)
def test_run_writes_a_complete_result(backend, tmp_path, cea):
    code, _, told = cea("run", "disc", "--backend", backend, *with_settings(QUICK))
    assert not code, told
    result = json.loads((tmp_path / "results" / "disc" / "result.json").read_text())
    assert result["scene"]["bodies"]["disc"]["backend"] == backend
    assert result["scene"]["analysis"]["max_frequency"] == 4000.0
    assert result["dofs"]["free"] == result["dofs"]["bodies"]["disc"] > 0
    assert {"meshing", "assembly", "factorisation", "krylov"} <= set(result["timings"])
    assert "friction" in result["skipped"]
    assert {"petsc", "slepc", "numpy"} <= set(result["versions"])
    imaginary = [pair["im"] for pair in result["eigenvalues"]]
    assert imaginary == sorted(imaginary)
    assert imaginary
    assert min(imaginary) >= 0
    assert all(set(pair) >= {"re", "im", "residual"} for pair in result["eigenvalues"])


ON_A_FULL_DISK = """
import resource, sys
import cea.petsc  # MPI has files of its own
resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))
from comparisons.cli.app import main
sys.argv[0] = "cea"
main()
"""


@pytest.mark.slow
def test_a_full_disk_ends_in_one_line(tmp_path):
    for more in ([], ["output.paraview=1"]):
        settings = with_settings([*QUICK, *more])
        program = [sys.executable, "-c", ON_A_FULL_DISK, "run", "disc", *settings]
        done = subprocess.run([*program, "--out", str(tmp_path)], capture_output=True, text=True)
        assert done.returncode == 1
        assert len(done.stderr.splitlines()) == 1, done.stderr
        assert "cannot be written: File too large" in done.stderr
        assert list(tmp_path.iterdir()) == []
