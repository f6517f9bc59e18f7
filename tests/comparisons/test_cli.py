"""The command line as a person meets it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

QUICK = [
    "bodies.disc.mesh.iga={degree=[2,2,2],elements=[3,8,1]}",
    "bodies.disc.mesh.fe={degree=1,elements=[3,12,1]}",
    "analysis.max_frequency=4000.0",
]


def cea(*arguments):
    return subprocess.run(
        [Path(sys.executable).with_name("cea"), *arguments], capture_output=True, text=True
    )


def with_settings(settings):
    return [part for setting in settings for part in ("--set", setting)]


@pytest.mark.parametrize(
    ("arguments", "field", "told"),
    [
        (
            ["disc_pad", "--set", "contacts.pad_disc.mue=0.3"],
            "contacts.pad_disc.mue",
            "no such field",
        ),
        (
            ["disc_pad", "--set", "contacts.pad_disc.b=disc.rim"],
            "contacts.pad_disc.b",
            "disc.outer",
        ),
        (
            ["disc_pad", "--set", "bodies.pad.material.rho=-1.0"],
            "bodies.pad.material.rho",
            "positive",
        ),
        (
            ["disc_pad", "--set", "bodies.pad.material={E=8e9,nu=0.3}"],
            "bodies.pad.material.rho",
            "density",
        ),
        (
            ["disc_pad", "--set", "contacts.pad_disc.a=pad.outer"],
            "contacts.pad_disc",
            "face each other",
        ),
        (["no_such_scene"], "scene", "disc_pad"),
    ],
)
def test_faults_are_one_line_without_traceback(arguments, field, told, tmp_path):
    done = cea("run", *arguments, "--out", str(tmp_path))
    assert done.returncode != 0
    assert "Traceback" not in done.stdout + done.stderr
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(f"error: {field} = ")
    assert told in lines[0]
    assert not (tmp_path / "result.json").exists()


def test_run_writes_a_complete_result(backend, tmp_path):
    done = cea("run", "disc", "--backend", backend, *with_settings(QUICK), "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "result.json").read_text())
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
