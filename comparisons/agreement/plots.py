"""Plots that the page of a comparison draws itself, each made of its data."""

from collections.abc import Iterator
from itertools import groupby
from math import tau
from typing import Any

from comparisons.agreement.figures import COLOURS
from comparisons.agreement.tables import stage_times
from comparisons.kit.interactive import Plot, literal, logarithmic, titled
from comparisons.kit.numbers import growth, number
from comparisons.kit.plots import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    YELLOW,
)
from comparisons.kit.tables import Data
from scenes.names import backend_name

_SYMBOLS = {"fe": "square", "iga": "circle"}
"""Marker of each backend."""
_SIZES = {"fe": (15.0, 2.5), "iga": (8.5, 1.5)}
"""Size of the first formulation's marker (pixels), and how much less the next is."""
_STAGES = (GREY, YELLOW, SKY, BLUE, VERMILION, GREEN, PURPLE, ORANGE)
_LINES = (VERMILION, ORANGE, BLUE, GREEN, PURPLE, SKY)


def run_label(run: Data) -> str:
    """Backend and formulation of a run."""
    return f"{backend_name(run['backend'])}, {run['formulation']}"


def patch_stresses(data: Data) -> list[Plot]:
    """Normal stress of both sides along the diagonal, at the least P; a plot for each rule."""
    part = data["patch_test"]
    P = min(run["P"] for run in part["runs"])
    chosen = [run for run in part["runs"] if run["P"] == P]
    exact = part["exact_sigma_n"]
    largest = max((abs(s - exact) for run in chosen for s in _stresses(run)), default=0.0)
    y = titled("σₙ (N/m²)", range=[exact - 1.1 * largest, exact + 1.1 * largest])
    return [
        Plot(
            f"patch-{i}",
            [*_sides(run), _exact(run, part["exact_sigma_n"])],
            titled("along the diagonal (m)"),
            y,
            height=210,
            title=run_label(run),
            file="patch_stresses.csv",
            options={"showlegend": False},
        )
        for i, run in enumerate(chosen)
    ]


def _stresses(run: Data) -> Iterator[float]:
    for sampled in run["stresses"]["interface"].values():
        yield from (s for s in sampled["sigma_n_along"] if s is not None)


def _sides(run: Data) -> Iterator[dict[str, Any]]:
    sides = run["stresses"]["interface"]
    for side, colour, dash in (("b", BLUE, "solid"), ("a", VERMILION, "dash")):
        oscillation = number(sides[side]["oscillation"])
        yield {
            "type": "scatter",
            "mode": "lines",
            "name": f"side {side}",
            "x": sides[side]["arc"],
            "y": sides[side]["sigma_n_along"],
            "line": {"color": colour, "dash": dash, "width": 1.6},
            "hovertemplate": f"%{{x:.3g}} m: %{{y:.6g}} N/m²<br>oscillation {oscillation}",
        }


def _exact(run: Data, exact: float) -> dict[str, Any]:
    arc = run["stresses"]["interface"]["a"]["arc"]
    return {
        "type": "scatter",
        "mode": "lines",
        "name": "exact",
        "x": [arc[0], arc[-1]],
        "y": [exact, exact],
        "line": {"color": BLACK, "width": 1, "dash": "dot"},
        "hoverinfo": "skip",
    }


def stability(data: Data) -> Plot:
    """Growth rate against frequency of every mode: backends by marker, formulations by colour.

    Unstable modes are filled.
    """
    drawn = dict.fromkeys(_SIZES, 0)
    traces = []
    for i, run in enumerate(data["disc_pad"]["runs"]):
        # Where modes agree their markers stand inside one another, and each is seen.
        largest, step = _SIZES[run["backend"]]
        size = largest - step * drawn[run["backend"]]
        drawn[run["backend"]] += 1
        traces.append(_modes(i, run, size))
    ring = {"symbol": "circle-open", "size": 24, "color": BLACK, "line": {"width": 2}}
    shown = {"type": "scatter", "mode": "markers", "x": [], "y": [], "marker": ring}
    traces.append(shown | {"name": "mode shown", "meta": "shown", "hoverinfo": "skip"})
    return Plot(
        "stability",
        traces,
        titled("frequency (Hz)", rangemode="tozero"),
        titled("growth rate (1/s)", zerolinewidth=1.5),
        height=480,
        file="eigenvalues.csv",
        options={"meta": {"narrow": 110}},
    )


def _modes(i: int, run: Data, size: float) -> dict[str, Any]:
    unstable = {mode["mode"] for mode in run["unstable"]}
    symbol, colour = _SYMBOLS[run["backend"]], COLOURS[run["method"]]
    values = list(enumerate(run["eigenvalues"], start=1))
    return {
        "type": "scatter",
        "mode": "markers",
        "name": literal(run_label(run)),
        "x": [value["im"] / tau for _, value in values],
        "y": [value["re"] for _, value in values],
        "customdata": [f"{i}/{j}" for j, _ in values],
        "text": [
            f"mode {j}{', unstable' if j in unstable else ''}<br>"
            f"{number(value['im'] / tau, 6)} Hz<br>growth {growth(value['re'])} 1/s<br>"
            f"residual {number(value['residual'], 2)}, condition {number(value['condition'])}"
            for j, value in values
        ],
        "hovertemplate": "%{text}<extra>%{fullData.name}</extra>",
        "marker": {
            "symbol": [symbol if j in unstable else f"{symbol}-open" for j, _ in values],
            "size": size,
            "color": colour,
            "line": {"width": 1.4, "color": colour},
            "opacity": 0.85,
        },
    }


def disc_errors(data: Data) -> list[Plot]:
    """Errors of the disc's frequencies against run time, and against dofs."""
    lines: dict[str, list[Data]] = {}
    for run in data["disc_alone"]["runs"]:
        lines.setdefault(run["line"], []).append(run)
    y = logarithmic("worst relative error of a frequency")
    return [
        Plot(
            f"disc-{name}",
            [_line(i, line, runs, key) for i, (line, runs) in enumerate(lines.items())],
            logarithmic(title),
            y,
            height=420,
            title=f"against {name}",
            file="disc_alone.csv",
            options={"meta": {"narrow": 90}},
        )
        for name, title, key in (("time", "run time (s)", "seconds"), ("dofs", "dofs", "dofs"))
    ]


def _line(i: int, line: str, runs: list[Data], key: str) -> dict[str, Any]:
    colour = _LINES[i % len(_LINES)]
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "name": literal(line),
        "x": [run["seconds"] if key == "seconds" else run["dofs"]["free"] for run in runs],
        "y": [run["worst_error"] for run in runs],
        "text": [
            f"{literal(run['mesh'])}<br>{number(run['dofs']['free'])} dofs, "
            f"{number(run['seconds'], 3)} s<br>worst {number(run['worst_error'], 2)}, median "
            f"{number(run['median_error'], 2)}"
            for run in runs
        ],
        "hovertemplate": "%{text}<extra>%{fullData.name}</extra>",
        "line": {"color": colour, "width": 1.8},
        "marker": {"symbol": _SYMBOLS[runs[0]["backend"]], "size": 8, "color": colour},
    }


def stage_bars(data: Data) -> list[Plot]:
    """Run time of every run by stage as stacked bars, a plot for each part."""
    table = stage_times(data)
    stages = [column.title for column in table.columns[2:-1]]
    plots: list[Plot] = []
    for part, group in groupby(table.rows, key=lambda row: row[0]):
        rows = list(group)
        place = list(range(len(rows)))
        y = {
            "tickvals": place,
            "ticktext": [literal(row[1]) for row in rows],
            "range": [len(rows) - 0.4, -0.6],
            "showgrid": False,
            "zeroline": False,
        }
        bars = [_bars(j, stage, rows, place) for j, stage in enumerate(stages)]
        plots.append(
            Plot(
                f"stages-{len(plots)}",
                bars,
                titled("seconds"),
                y,
                height=110 + 24 * len(rows),
                title=part,
                file="stage_times.csv",
                options={
                    "barmode": "stack",
                    "bargap": 0.25,
                    "showlegend": not plots,
                    "meta": {"narrow": 24 * len(rows)},
                },
            )
        )
    return plots


def _bars(j: int, stage: str, rows: list[tuple[Any, ...]], place: list[int]) -> dict[str, Any]:
    return {
        "type": "bar",
        "orientation": "h",
        "name": stage,
        "x": [row[2 + j] for row in rows],
        "y": place,
        "marker": {"color": _STAGES[j % len(_STAGES)]},
        "text": [literal(row[1]) for row in rows],
        "textposition": "none",
        "hovertemplate": "%{text}<br>" + stage + ": %{x:.3f} s<extra></extra>",
    }
