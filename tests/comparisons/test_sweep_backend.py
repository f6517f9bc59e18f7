"""``cea sweep`` and ``cea threshold`` with every body on one backend."""

import json
import sys

import pytest

from cea.errors import InputError
from comparisons.cli.app import main
from comparisons.cli.options import with_backend
from scenes.spec.reading import load_scene

COARSE = (
    "bodies.upper.mesh.fe.elements=[6,2]",
    "bodies.lower.mesh.fe.elements=[5,2]",
    "bodies.upper.mesh.iga.elements=[6,2]",
    "bodies.lower.mesh.iga.elements=[5,2]",
    "analysis.max_frequency=0.3",
)


def test_every_body_is_put_on_the_backend(backend):
    made = with_backend("blocks", COARSE, backend)
    assert made[: len(COARSE)] == COARSE
    assert load_scene("blocks", made) == load_scene("blocks", COARSE, backend)


def test_without_a_backend_the_scene_is_as_it_says():
    assert with_backend("blocks", COARSE, None) == COARSE


def test_scenes_of_matrices_are_refused(backend):
    with pytest.raises(InputError, match="no bodies"):
        with_backend("tu_berlin", (), backend)


@pytest.mark.grid
@pytest.mark.parametrize("command", ["sweep", "threshold"])
def test_the_commands_run_on_the_backend(command, backend, tmp_path, monkeypatch, capsys):
    settings = [part for each in COARSE for part in ("--set", each)]
    chosen = ["--backend", backend, *settings, "--out", str(tmp_path / "out")]
    monkeypatch.setattr(sys, "argv", ["cea", command, "blocks", "mu=0:0.2:3", *chosen])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code, capsys.readouterr().err
    found = json.loads((tmp_path / "out" / "result.json").read_text())
    assert f'bodies.upper.backend="{backend}"' in found["inputs"]["set"]
    # Of 19 x 7 and 16 x 7 nodes, 9 x 5 and 8 x 5 functions: one edge clamped, two on rollers.
    assert found["unknowns"] == {"fe": 216 + 180, "iga": 64 + 56}[backend]
