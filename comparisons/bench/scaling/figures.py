"""Processor time of each stage against unknowns and degree, and both inverses."""

from matplotlib.figure import Figure

from cea.timing import STAGES
from comparisons.bench.scaling.model import by_kind, solved, stage, total
from comparisons.kit.plots import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, styled
from comparisons.kit.tables import Data

_COLOURS = dict(zip(STAGES, (GREY, SKY, BLUE, VERMILION, ORANGE, GREEN), strict=True))


@styled
def unknowns_figure(data: Data) -> Figure:
    """Processor seconds of each stage, and of both inverses, over unknowns."""
    figure = Figure(figsize=(8.6, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    runs = [run for run in by_kind(data, "size") if not run["failed"]]
    for name in STAGES:
        points = [(run["answers"][0]["unknowns"], stage(run, name)) for run in runs]
        points = [point for point in points if point[1] > 0]
        if points:
            left.loglog(*zip(*points, strict=True), "o-", color=_COLOURS[name], ms=4, label=name)
    left.set_ylabel("processor time, s")
    left.set_title("stages of a run")
    for way, label, colour in (
        ("mumps", "MUMPS", VERMILION),
        ("gamg", "GMRES, multigrid", BLUE),
    ):
        found = [i for i in data["inverses"] if solved(i) and i["way"] == way and not i["shift"]]
        n = [inverse["unknowns"] for inverse in found]
        for what, line in (("setup", "o--"), ("solve", "o-")):
            times = [inverse[what] for inverse in found]
            right.loglog(n, times, line, color=colour, ms=4, label=f"{label}: {what}")
    right.set_title("inverses")
    for axes in (left, right):
        axes.set_xlabel("unknowns")
        axes.legend()
    return figure


@styled
def degree_figure(data: Data) -> Figure:
    """Processor seconds of the whole run over degree, of both backends."""
    figure = Figure(figsize=(5.2, 3.6), layout="constrained")
    axes = figure.subplots()
    for backend, label, colour in (
        ("fe", "Lagrange hexahedra", BLUE),
        ("iga", "NURBS", PURPLE),
    ):
        runs = [
            run
            for run in by_kind(data, "degree")
            if not run["failed"] and run["backend"] == backend
        ]
        degrees = [run["degree"] for run in runs]
        axes.semilogy(degrees, [total(r) for r in runs], "o-", color=colour, label=label)
        assembly = [stage(run, "assembly") for run in runs]
        axes.semilogy(degrees, assembly, "o--", color=colour, label=f"{label}: assembly")
    axes.set_xlabel("degree")
    axes.set_ylabel("processor time, s")
    axes.legend()
    return figure


FIGURES = {"unknowns": unknowns_figure, "degree": degree_figure}
