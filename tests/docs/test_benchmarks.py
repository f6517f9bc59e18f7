"""The benchmarks' numbers are those of the commands that stand above them."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from comparisons.cli.exact import app
from exact_cea.lumped import hoffmann_threshold, hulten_threshold

TEXT = (Path(__file__).parents[2] / "docs" / "benchmarks.md").read_text(encoding="utf-8")
LISTS = re.findall(r"^    \$ cea exact (.*)\n((?: +[-0-9.]+ +[-0-9.]+\n)+)", TEXT, re.MULTILINE)
_ROW = re.compile(r"^ +(\S+) +(\S+)$", re.MULTILINE)
_THRESHOLD = re.compile(r"mu_c=(\S+) .*omega=(\S+)")
QUICK = ("drum", "hoffmann", "hulten", "blocks --count")
"""Commands that take a second or two."""


def told(rows):
    """Numbers of a list as they are written."""
    return [tuple(row.split()) for row in rows.splitlines()]


def digits(text):
    """Significant digits of a number."""
    return len(text.lstrip("-0.").replace(".", ""))


@pytest.mark.grid(quick=4)
@pytest.mark.parametrize(
    ("command", "rows"),
    [pytest.param(*row, marks=() if row[0].startswith(QUICK) else pytest.mark.slow)
     for row in LISTS],
    ids=[command for command, _ in LISTS],
)  # fmt: skip
def test_eigenvalues_are_those_of_the_command(command, rows):
    done = CliRunner().invoke(app, command.split(), catch_exceptions=False)
    form = _THRESHOLD if "--thresholds" in command else _ROW
    found = form.findall(done.stdout)
    if form is _ROW:
        found = [row for row in found if float(row[1]) >= 0]
    assert len(told(rows)) == len(found) > 0
    for written, computed in zip(told(rows), found, strict=True):
        for text, value in zip(written, computed, strict=True):
            if text == "0":
                assert float(value) == 0
                continue
            assert digits(text) in (10, 11, 12)
            # Half a unit of the last digit that is written.
            unit = 10.0 ** -len(text.partition(".")[2])
            assert abs(float(text) - float(value)) <= 0.51 * unit


def test_closed_forms_in_the_text_are_those_of_the_program():
    (mu_c,) = re.findall(r"4 k12 k3\) = ([\d.]+)\.\n", TEXT)
    assert float(mu_c) == float(hoffmann_threshold())
    (mu_c,) = re.findall(r"sqrt\(k1 k2\)\) = ([\d.]+)\.\n", TEXT)
    assert float(mu_c) == pytest.approx(float(hulten_threshold()[0]), abs=5e-13)
    ((mu_c, square),) = re.findall(r"to mu_c = ([\d.]+), at omega\^2 = ([\d.]+):", TEXT)
    damped = hulten_threshold(c1="0.02", c2="0.1")
    assert [float(mu_c), float(square)] == pytest.approx([float(x) for x in damped], rel=5e-12)
