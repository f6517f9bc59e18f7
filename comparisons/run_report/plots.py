"""Plots of the report of a run, made of its record."""

from math import tau
from typing import Any

from comparisons.kit.interactive import VERDICT_MARKS, Plot, literal, marks, titled
from comparisons.kit.plots import BLUE
from comparisons.kit.tables import Data
from comparisons.run_report.tables import damping_ratio


def stability(data: Data, key: str) -> Plot:
    """Growth rate against frequency of every mode; a point stands for the mode it shows.

    Parameters
    ----------
    data
        Record of the run.
    key
        Name of its modes on the page.
    """
    traces = [_with_verdict(data, key, verdict) for verdict in VERDICT_MARKS]
    ring = {"symbol": "circle-open", "size": 18, "color": "#222222", "line": {"width": 2}}
    traces = [trace for trace in traces if trace["x"]]
    traces.append(
        _points([], [], ring) | {"name": "mode shown", "meta": "shown", "hoverinfo": "skip"}
    )
    return Plot(
        "stability",
        traces,
        titled("frequency (Hz)", rangemode="tozero"),
        titled("growth rate (1/s)", zeroline=True, zerolinewidth=1.5),
        height=480,
    )


def _points(x: list[float], y: list[float], marker: dict[str, Any]) -> dict[str, Any]:
    return {"type": "scatter", "mode": "markers", "x": x, "y": y, "marker": marker}


def _with_verdict(data: Data, key: str, verdict: str) -> dict[str, Any]:
    chosen = [
        (i, value) for i, value in enumerate(data["eigenvalues"], 1) if value["verdict"] == verdict
    ]
    marker = marks(verdict, size=11 if verdict == "unstable" else 8, line={"width": 0.5})
    points = _points([v["im"] / tau for _, v in chosen], [v["re"] for _, v in chosen], marker)
    return points | {
        "name": verdict,
        "customdata": [f"{key}/{i}" for i, _ in chosen],
        "text": [_hover(i, value) for i, value in chosen],
        "hovertemplate": "%{text}<extra></extra>",
    }


def _hover(i: int, value: Data) -> str:
    ratio = damping_ratio(value)
    damping = "–" if ratio is None else f"{ratio:.3g}"
    return (
        f"mode {i}, {literal(value['verdict'])}<br>{value['im'] / tau:.2f} Hz<br>"
        f"growth {value['re']:+.4g} ± {value['uncertainty']:.1g} 1/s<br>"
        f"damping ratio {damping}<br>condition {value['condition']:.3g}"
    )


def stages(data: Data) -> Plot:
    """Seconds by stage as bars."""
    named = {name: seconds for name, seconds in data["timings"].items() if seconds > 0}
    return Plot(
        "stages",
        [
            {
                "type": "bar",
                "orientation": "h",
                "x": list(named.values()),
                "y": [literal(name) for name in named],
                "marker": {"color": BLUE},
                "hovertemplate": "%{y}: %{x:.3f} s<extra></extra>",
            }
        ],
        titled("seconds"),
        {"autorange": "reversed"},
        height=70 + 30 * len(named),
    )


def side_stresses(data: Data) -> list[Plot]:
    """Normal stress along a line over each side of each contact of a static analysis."""
    return [
        Plot(
            f"stress-{i}",
            [
                {
                    "type": "scatter",
                    "mode": "lines",
                    "name": f"side {side}",
                    "x": sampled["arc"],
                    "y": sampled["sigma_n_along"],
                    "line": {"dash": "dash" if side == "a" else "solid"},
                    "hovertemplate": "%{x:.4g} m: %{y:.6g} N/m²<extra>%{fullData.name}</extra>",
                }
                for side, sampled in sides.items()
            ],
            titled("along the surface (m)"),
            titled("σₙ (N/m²)"),
            title=name,
        )
        for i, (name, sides) in enumerate(data["stresses"].items())
    ]
