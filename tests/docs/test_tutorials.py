"""The tutorial of a brake from a mesh file, followed as it is written."""

import re
import shlex
from pathlib import Path
from textwrap import dedent

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from comparisons.cli.app import app

TEXT = (Path(__file__).parents[2] / "docs" / "tutorials" / "own_brake.md").read_text("utf-8")


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Runs a command in a folder with the mesh and the scene of the tutorial."""
    monkeypatch.chdir(tmp_path)

    def run(line, code=0):
        done = CliRunner().invoke(app, shlex.split(line)[1:])
        assert done.exit_code == code, done.output
        return done.output

    export = re.search(r"    (cea scene export .*?)\n\n", TEXT, re.S)[1]
    run(export.replace("\\\n", " "))
    scene = re.search(r"        name = .*?(?=\n\n3\. )", TEXT, re.S)[0]
    Path("brake.toml").write_text(dedent(scene))
    return run


def commands():
    """Those of the steps, by name."""
    return {line.split()[1]: line for line in re.findall(r"`(cea .*?)`", TEXT)}


def test_a_run_answers_as_the_tutorial_says(command):
    assert "no faults" in command(commands()["scene"])
    told = re.search(r"answers `(.*?)`", TEXT)[1]
    assert told in command(commands()["run"])


@pytest.mark.slow
def test_thresholds_and_bars_are_those_of_the_tutorial(command):
    command(commands()["threshold"])
    found = pd.read_csv("results/threshold/thresholds.csv")
    told = np.array(re.findall(r"(0\.\d+)\s+\((\d+) Hz\)", TEXT), dtype=float)
    np.testing.assert_allclose(found["mu"], told[:, 0], rtol=5e-4)
    np.testing.assert_allclose(found["frequency"], told[:, 1], atol=0.5)

    command(commands()["converge"], code=3)
    modes = pd.read_csv("results/converge/modes.csv")
    kilohertz, verdict = modes["frequency"] / 1e3, modes["verdict"]
    assert "◆ undecided" in set(verdict[(kilohertz - 7.4).abs() < 0.05])
    told, bar = map(float, re.search(r"(\d+) ± (\d+) Hz", TEXT).groups())
    grows = modes[verdict == "▲ unstable"].iloc[0]
    assert grows["frequency"] == pytest.approx(told, abs=0.5)
    assert grows["frequency_bar"] == pytest.approx(bar, abs=0.5)
