"""Growth rates over frequency: of every mesh, and of every contact stiffness."""

from collections.abc import Iterable

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from comparisons.kit.numbers import plain
from comparisons.kit.plots import AXIS, BLUE, GREEN, ORANGE, VERMILION, styled
from comparisons.kit.tables import Data

_LOOKS = ((ORANGE, "^", 7), (GREEN, "s", 5), (BLUE, "o", 3.5), (VERMILION, "D", 3))
"""Colour, marker and its size, larger ones below."""


@styled
def brake_figure(data: Data) -> Figure:
    """Eigenvalues of all meshes on the left, of all stiffnesses on the coarsest on the right."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    meshes, stiffnesses = figure.subplots(1, 2, sharex=True)
    _eigenvalues(meshes, [(f"{run['size'] * 1e3:g} mm", run) for run in data["runs"]])
    meshes.set_title("Meshes, by the length of their elements")
    runs = [(f"{plain(run['p'])} N/m³", run) for run in data["stiffnesses"]]
    _eigenvalues(stiffnesses, runs)
    stiffnesses.set_title("Contact stiffness p, on the coarsest mesh")
    meshes.set_ylabel("growth rate (1/s)")
    return figure


def _eigenvalues(axes: Axes, runs: Iterable[tuple[str, Data]]) -> None:
    axes.axhline(0.0, color=AXIS, linewidth=0.8)
    for i, (label, run) in enumerate(runs):
        colour, marker, size = _LOOKS[i % len(_LOOKS)]
        axes.plot(
            [mode["frequency"] for mode in run["modes"]],
            [mode["growth"] for mode in run["modes"]],
            marker,
            color=colour,
            markersize=size,
            label=label,
            zorder=3 + i,
        )
    axes.set_xlabel("frequency (Hz)")
    axes.legend()
