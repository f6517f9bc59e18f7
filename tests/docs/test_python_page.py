"""The lines for a notebook run as written, on coarser meshes."""

import re
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest
from PIL import Image

import scenes

PAGE = (Path(__file__).parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
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
    code = dedent("".join(re.findall(r"^(?: {4}.*)?\n", PAGE, re.MULTILINE)))
    names = {}
    exec(compile(code, "python.md", "exec"), names)
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("disc_pad: 14 modes up to 7000 Hz: 1 unstable")
    assert [line.split()[0] for line in told[-3:]] == ["0.0", "0.2", "0.4"]
    assert Image.open("mode_14.png").size == (1500, 900)
    opened = scenes.open_result("results/mine/result.json")
    assert opened.table() == names["table"]
    np.testing.assert_array_equal(names["table"].column("mode"), np.arange(1, 15))
