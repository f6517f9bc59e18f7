"""What README, the page for notebooks and the tutorial tell one to type works as written."""

import re
import shlex
from pathlib import Path
from textwrap import dedent

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from typer.testing import CliRunner

import scenes
from comparisons.cli.app import app
from scenes import load_scene, run_modes

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PYTHON = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
TUTORIAL = (ROOT / "docs" / "tutorials" / "own_brake.md").read_text(encoding="utf-8")


def block(language):
    """The one block of code in a language."""
    (text,) = re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)
    return text


@pytest.fixture
def first_scene(tmp_path, monkeypatch):
    """The first scene, saved as README says, in the folder one is in."""
    monkeypatch.chdir(tmp_path)
    Path("pad_on_bar.toml").write_text(block("toml"), encoding="utf-8")
    return load_scene("pad_on_bar.toml")


def assert_as_told(modes):
    (told,) = re.findall(r"one unstable mode near ([\d.]+) kHz", README)
    (unstable,) = modes.frequencies[modes.growth_rates > 1.0]
    assert unstable == pytest.approx(1e3 * float(told), rel=0.02)


def test_the_first_scene_has_the_unstable_mode_that_is_told(first_scene):
    """With tetrahedra; of NURBS below."""
    assert_as_told(run_modes(first_scene.on("fe")).modes)


def test_the_lines_of_python_run(first_scene, capsys):
    names = {}
    exec(compile(block("python"), "README.md", "exec"), names)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[-3:]]
    assert [row[0] for row in rows] == ["0.3", "0.4", "0.5"]
    assert float(rows[0][1]) < 1.0
    assert float(rows[-1][1]) == pytest.approx(names["result"].growth_rates.max())
    assert_as_told(names["result"].modes)
    assert names["M"].shape == names["K"].shape == 2 * (names["result"].system.size,)


COARSE = {
    "bodies.pad.mesh.iga.elements": [3, 5, 1],
    "bodies.disc.mesh.iga.elements": [6, 28, 1],
    "analysis.max_frequency": 7000.0,
}


@pytest.mark.slow
def test_the_lines_for_a_notebook_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    load = scenes.load_scene
    monkeypatch.setattr(scenes, "load_scene", lambda name: load(name).change(COARSE), raising=False)
    code = dedent("".join(re.findall(r"^(?: {4}.*)?\n", PYTHON, re.MULTILINE)))
    names = {}
    exec(compile(code, "python.md", "exec"), names)
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("disc_pad: 14 modes up to 7000 Hz: 1 unstable")
    assert [line.split()[0] for line in told[-3:]] == ["0.0", "0.2", "0.4"]
    assert Image.open("mode_14.png").size == (1500, 900)
    opened = scenes.open_result("results/mine/result.json")
    assert opened.table() == names["table"]
    np.testing.assert_array_equal(names["table"].column("mode"), np.arange(1, 15))


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Runs a command in a folder with the mesh and the scene of the tutorial."""
    monkeypatch.chdir(tmp_path)

    def run(line, code=0):
        done = CliRunner().invoke(app, shlex.split(line)[1:])
        assert done.exit_code == code, done.output
        return done.output

    export = re.search(r"    (cea scene export .*?)\n\n", TUTORIAL, re.S)[1]
    run(export.replace("\\\n", " "))
    scene = re.search(r"        name = .*?(?=\n\n3\. )", TUTORIAL, re.S)[0]
    Path("brake.toml").write_text(dedent(scene))
    return run


def commands():
    """Those of the steps, by name."""
    return {line.split()[1]: line for line in re.findall(r"`(cea .*?)`", TUTORIAL)}


def test_a_run_answers_as_the_tutorial_says(command):
    assert "no faults" in command(commands()["scene"])
    told = re.search(r"answers `(.*?)`", TUTORIAL)[1]
    assert told in command(commands()["run"])


@pytest.mark.slow
def test_thresholds_and_bars_are_those_of_the_tutorial(command):
    command(commands()["threshold"])
    found = pd.read_csv("results/threshold/thresholds.csv")
    told = np.array(re.findall(r"(0\.\d+)\s+\((\d+) Hz\)", TUTORIAL), dtype=float)
    np.testing.assert_allclose(found["mu"], told[:, 0], rtol=5e-4)
    np.testing.assert_allclose(found["frequency"], told[:, 1], atol=0.5)

    command(commands()["converge"], code=3)
    modes = pd.read_csv("results/converge/modes.csv")
    kilohertz, verdict = modes["frequency"] / 1e3, modes["verdict"]
    assert "◆ undecided" in set(verdict[(kilohertz - 7.4).abs() < 0.05])
    told, bar = map(float, re.search(r"(\d+) ± (\d+) Hz", TUTORIAL).groups())
    grows = modes[verdict == "▲ unstable"].iloc[0]
    assert grows["frequency"] == pytest.approx(told, abs=0.5)
    assert grows["frequency_bar"] == pytest.approx(bar, abs=0.5)
