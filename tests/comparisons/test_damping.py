"""Thresholds of flutter against damping: elastic bodies, the exact lumped system, the report."""

import pytest
from typer.testing import CliRunner

from comparisons.cli.app import app
from comparisons.damping.report import read_damping, thresholds_table, write_damping
from comparisons.damping.scene import MODULUS
from comparisons.damping.study import (
    DampingStudy,
    computed_threshold,
    dampings,
    exact_threshold,
    run_damping,
)

STUDY = DampingStudy(("iga",), shares=(1.0, 10.0), ratios=(0.1,))


@pytest.fixture(scope="module")
def result():
    """A short study of one backend."""
    return run_damping(lambda _: None, STUDY)


def test_dampings_have_their_mean_and_their_share():
    c1, c2 = dampings(3.0, 0.02)
    first, second = c1 / 2, c2 / 2 / 1.2
    assert second / first == pytest.approx(3.0)
    assert (first + second) / 2 == pytest.approx(0.02)


@pytest.mark.grid(quick=1)
def test_elastic_bodies_flutter_where_the_lumped_system_does(backend):
    """Up to terms of the order k / E; damped so unlike that half of the friction suffices."""
    damping = dampings(10.0, 0.01)
    found, exact = computed_threshold(backend, *damping), exact_threshold(*damping)
    assert found == pytest.approx(exact, rel=1 / MODULUS)
    assert found == pytest.approx(0.098287, abs=1e-6)
    assert exact < 0.6 * exact_threshold(0.0, 0.0)


def test_damping_moves_thresholds_both_ways(result):
    by_kind = {(row["share"], row["ratio"]): row["iga"] for row in result["rows"]}
    assert by_kind[1.0, 0.1] > result["undamped"] > by_kind[10.0, 0.1]
    assert result["undamped"] == pytest.approx(0.44 / 2.4)


def test_the_report_is_written_and_drawn_anew(result, tmp_path):
    figure = write_damping(result, tmp_path)
    assert figure.stat().st_size > 10_000
    assert read_damping(tmp_path)["rows"] == result["rows"]
    rows = thresholds_table(result).rows
    assert max(row[-1] for row in rows) < 1e-6
    assert (tmp_path / "damping.csv").read_text().count("\n") == len(rows) + 1
    figure.unlink()
    told = CliRunner().invoke(app, ["damping", "--redraw", "--out", str(tmp_path)])
    assert told.exit_code == 0, told.output
    assert figure.is_file()
