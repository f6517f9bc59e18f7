"""What README tells a newcomer to type works as written."""

import re
from pathlib import Path

import pytest

from scenes import load_scene, run_modes

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


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


@pytest.mark.grid(quick=1)
def test_the_first_scene_has_the_unstable_mode_that_is_told(first_scene, backend):
    (told,) = re.findall(r"one unstable mode near ([\d.]+) kHz", README)
    modes = run_modes(first_scene.on(backend)).modes
    (unstable,) = modes.frequencies[modes.growth_rates > 1.0]
    assert unstable == pytest.approx(1e3 * float(told), rel=0.02)
    stable = run_modes(first_scene.on(backend).change("contacts.sliding.mu", 0.3)).modes
    assert stable.growth_rates.max() < 1.0


def test_the_lines_of_python_run(first_scene, capsys):
    names = {}
    exec(compile(block("python"), "README.md", "exec"), names)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[-3:]]
    assert [row[0] for row in rows] == ["0.3", "0.4", "0.5"]
    assert float(rows[-1][1]) == pytest.approx(names["result"].growth_rates.max())
    assert names["M"].shape == names["K"].shape == 2 * (names["result"].system.size,)
