"""Plots of a record: error against run time with the Pareto front, modes with their bars."""

from typing import Any

from comparisons.converge.tables import elements_text, error_of, floor_of, front_of, with_bar
from comparisons.kit.interactive import VERDICT_MARKS, Plot, literal, logarithmic, marks, titled
from comparisons.kit.plots import AXIS, BLUE, VERMILION
from comparisons.kit.tables import Data
from scenes.names import backend_name

_LOOKS = {"iga": (BLUE, "circle"), "fe": (VERMILION, "square")}


def errors_plot(data: Data) -> Plot:
    """Worst error of every mesh against its run time, both backends, with the Pareto front."""
    traces = [_of_backend(data, backend) for backend in data["backends"]]
    front = sorted(
        (data["levels"][i]["seconds"], error_of(data, data["levels"][i])) for i in front_of(data)
    )
    traces.append(
        {
            "type": "scatter",
            "mode": "lines",
            "name": "Pareto front",
            "x": [seconds for seconds, _ in front],
            "y": [error for _, error in front],
            "line": {"color": AXIS, "width": 1, "dash": "dot", "shape": "hv"},
            "hoverinfo": "skip",
        }
    )
    times = [level["seconds"] for level in data["levels"]]
    if (known := floor_of(data)) > 0 and times:
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": "largest bar of the final values",
                "x": [min(times), max(times)],
                "y": [known, known],
                "line": {"color": AXIS, "width": 1},
            }
        )
    return Plot(
        "errors",
        traces,
        logarithmic("run time (s)"),
        logarithmic("worst relative error of lambda"),
        height=420,
        file="levels.csv",
    )


def _of_backend(data: Data, backend: str) -> dict[str, Any]:
    levels = [
        (level, error)
        for level in data["levels"]
        if level["backend"] == backend and (error := error_of(data, level)) is not None
    ]
    colour, symbol = _LOOKS[backend]
    return {
        "type": "scatter",
        "mode": "markers+lines",
        "name": backend_name(backend),
        "x": [level["seconds"] for level, _ in levels],
        "y": [error or None for _, error in levels],
        "text": [_told(level) for level, _ in levels],
        "hovertemplate": "%{text}<br>%{x:.3g} s, error %{y:.2g}<extra></extra>",
        "marker": {"color": colour, "symbol": symbol, "size": 9},
        "line": {"color": colour, "width": 1},
    }


def _told(level: Data) -> str:
    return literal(f"degree {level['degree']}, {elements_text(level['elements'])}")


def modes_plot(data: Data) -> Plot:
    """Growth rate against frequency with bars."""
    traces = []
    for verdict in VERDICT_MARKS:
        chosen = [mode for mode in data["modes"] if mode["verdict"] == verdict]
        if chosen:
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": verdict,
                    "x": [mode["frequency"] for mode in chosen],
                    "y": [mode["growth"] for mode in chosen],
                    "error_x": _bars(chosen, "frequency_bar"),
                    "error_y": _bars(chosen, "growth_bar"),
                    "marker": marks(verdict, size=9),
                    "text": [_mode(mode) for mode in chosen],
                    "hovertemplate": "%{text}<extra></extra>",
                }
            )
    return Plot(
        "modes",
        traces,
        titled("frequency (Hz)"),
        titled("growth rate (1/s)", zeroline=True, zerolinewidth=1.5),
        height=420,
        file="modes.csv",
    )


def _bars(modes: list[Data], name: str) -> dict[str, Any]:
    return {"type": "data", "array": [mode[name] or 0.0 for mode in modes], "thickness": 1}


def _mode(mode: Data) -> str:
    frequency = with_bar(mode["frequency"], mode["frequency_bar"])
    growth = with_bar(mode["growth"], mode["growth_bar"])
    return literal(f"{frequency} Hz, {growth} 1/s, {mode['verdict']}")
