"""The command line ``cea``: a function for each command."""

from math import tau
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from cea.petsc import MPI
from comparisons.cli.exact import app as exact_app
from comparisons.cli.ranks import one_voice

if TYPE_CHECKING:
    from comparisons.kit.tables import Table as ReportTable

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
app.add_typer(exact_app, name="exact")
console = Console()
_TABLE_WIDTH = 120

_Out = Annotated[Path, typer.Option("--out", help="Folder for result.json and all else.")]


@app.command()
def run(
    scene: Annotated[Path, typer.Argument(help="TOML file, or the name of a scene.")],
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override, e.g. contacts.pad_disc.mu=0.3")
    ] = None,
    backend: Annotated[
        Literal["fe", "iga"] | None, typer.Option(help="Backend for every body.")
    ] = None,
    out: _Out = Path("results/run"),
) -> None:
    """Run one scene and write its result.json."""
    from scenes.read import load_scene
    from scenes.results import describe, write_json
    from scenes.run import run_scene

    with console.status("reading the scene") as status:
        result = run_scene(
            load_scene(scene, set_ or (), backend),
            listener=lambda stage: status.update(stage),
        )
        data = describe(result)
        if result.scene.output.pictures:
            from scenes.pictures import draw_modes

            status.update("pictures")
            pictures = draw_modes(result, result.scene.output.pictures, out, animated=True)
            data["pictures"] = [file.name for file in pictures]
        if result.scene.output.paraview:
            from scenes.paraview import write_paraview

            status.update("files for ParaView")
            collections = write_paraview(result, result.scene.output.paraview, out)
            data["paraview"] = [file.name for file in collections]
    if MPI.COMM_WORLD.rank == 0:
        write_json(data, out / "result.json")
    if result.modes is not None:
        _print_modes(data)
    for name, sides in data.get("stresses", {}).items():
        for side, stress in sides.items():
            console.print(
                f"{name}, side {side}: sigma_n from {stress['min']:.6g} to {stress['max']:.6g}, "
                f"oscillation {stress['oscillation']:.6g} N/m^2"
            )
    typer.echo(f"{data['dofs']['free']} dofs, {data['seconds']:.2f} s; {out / 'result.json'}")


@app.command()
def compare(out: _Out = Path("results/compare")) -> None:
    """Run both scenes on both backends with every formulation and write the report."""
    from comparisons.agreement import tables
    from comparisons.agreement.page import write_report
    from comparisons.agreement.study import compare as run_comparison
    from comparisons.kit.progress import Progress

    with console.status("compare") as status:
        step = ""

        def begin(name: str) -> None:
            nonlocal step
            step = name
            console.print(f"· {name}")
            status.update(name)

        data, results = run_comparison(
            Progress(step=begin, stage=lambda stage: status.update(f"{step}: {stage}"))
        )
        begin("report")
        report = write_report(data, results, out)
    for make in (tables.patch_test, tables.agreement, tables.disc_alone):
        _print_table(make(data))
    typer.echo(f"The report to open: {report}")


@app.command()
def figure(
    name: Annotated[
        str, typer.Argument(help="Number of a figure of the paper, a study by name, or all.")
    ],
    backend: Annotated[
        Literal["fe", "iga", "both"], typer.Option(help="Backend for every body, or both together.")
    ] = "iga",
    out: _Out = Path("results/figures"),
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Compute even where stored data could be drawn.")
    ] = False,
) -> None:
    """Make a figure of the paper: data, pictures, and its numbers beside those of the text."""
    from comparisons.kit.progress import Progress
    from comparisons.paper.both_backends import make_both
    from comparisons.paper.common.store import make_figure
    from comparisons.paper.registry import chosen

    for each in chosen(name):
        with console.status(each.title) as status:
            progress = Progress(step=status.update, stage=lambda stage: None)
            pictures = []
            if backend == "both":
                both = make_both(each, out, progress, recompute=recompute)
                every, pictures = list(both.made.values()), both.pictures
            else:
                every = [make_figure(each, backend, out, progress, recompute=recompute)]
        for made in every:
            if MPI.COMM_WORLD.rank == 0:
                _print_table(made.numbers)
                typer.echo(made.note)
            drawn = ", ".join(map(str, made.pictures))
            typer.echo(f"{'drawn from stored data' if made.reused else made.data_file}; {drawn}")
        if pictures:
            typer.echo(f"both: {', '.join(map(str, pictures))}")


@app.command()
def claims(out: _Out = Path("results/figures")) -> None:
    """Judge the paper's claims by the figures' data; what is not stored is computed."""
    from comparisons.kit.progress import Progress
    from comparisons.paper.claims.judge import judge, write_claims

    with console.status("claims") as status:
        judged = judge(out, Progress(step=status.update, stage=lambda stage: None))
    if MPI.COMM_WORLD.rank == 0:
        for each in judged:
            typer.echo(each.told())
        typer.echo(", ".join(map(str, write_claims(judged, out))))


@app.command()
def formulations(
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: _Out = Path("results/formulations"),
) -> None:
    """Patch tests, locking, momentum, numbers of the paper, pairings of backends: one page."""
    from comparisons.formulations.page import read_formulations, write_formulations
    from comparisons.formulations.study import run_formulations
    from comparisons.kit.progress import Progress

    with console.status("formulations") as status:
        if redraw:
            data = read_formulations(out)
        else:
            data = run_formulations(
                Progress(step=status.update, stage=lambda stage: None),
                lambda part: console.print(f"· {part}"),
            )
        status.update("report")
        report = write_formulations(data, out)
    typer.echo(f"The report to open: {report}")


@app.command()
def accuracy(
    problems: Annotated[
        list[str] | None, typer.Argument(help="Problems with exact eigenvalues; all by default.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="5 minutes instead of an hour.")] = False,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, do not run the study.")
    ] = False,
    finest: Annotated[
        bool,
        typer.Option(
            "--finest",
            help="Beside it, run the finest meshes and problems that cannot flutter (an hour).",
        ),
    ] = False,
    out: _Out = Path("results/accuracy"),
) -> None:
    """Measure the error of every method against run time, on problems with exact eigenvalues."""
    from comparisons.accuracy import page
    from comparisons.accuracy.finest import run_finest
    from comparisons.accuracy.no_flutter import run_still
    from comparisons.accuracy.problems import PROBLEMS, problem
    from comparisons.accuracy.runner import run_study
    from comparisons.accuracy.study import FULL, QUICK

    with console.status("accuracy") as status:
        if redraw:
            data = page.read(out)
        else:
            names = [problem(name).name for name in problems or PROBLEMS]
            data = run_study(QUICK if quick else FULL, names, status.update)
        if finest:
            data["still"] = run_still(status.update)
            data["finest"] = run_finest(progress=status.update)
    typer.echo(f"The report to open: {page.write(data, out)}")


@app.command()
def reference(
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Run it anew (some minutes, 12 GB) and compare.")
    ] = False,
    out: _Out = Path("results/reference"),
) -> None:
    """Show the converged modes of disc_pad, on which both backends agree."""
    from comparisons.kit.progress import Progress
    from comparisons.reference.study import compute_reference, stored_reference
    from comparisons.reference.tables import reference_table
    from scenes.results import write_json

    data = stored_reference()
    if recompute:
        with console.status("reference") as status:
            data = compute_reference(Progress(step=console.print, stage=status.update))
    table = reference_table(data)
    if MPI.COMM_WORLD.rank == 0:
        write_json(data, out / "disc_pad_reference.json")
        table.write_csv(out)
    _print_table(table)
    typer.echo(f"{out / 'disc_pad_reference.json'}")


def _print_table(table: "ReportTable") -> None:
    shown = Table(title=table.caption, title_justify="left", box=SIMPLE_HEAD)
    for column in table.columns:
        unit = f" ({column.unit})" if column.unit else ""
        shown.add_column(
            column.title + unit, no_wrap=True, justify="right" if column.show else "left"
        )
    for cells in table.cells():
        shown.add_row(*cells)
    Console(width=max(console.width, _TABLE_WIDTH)).print(shown)


def _print_modes(data: dict[str, Any]) -> None:
    table = Table("mode", "frequency (Hz)", "growth rate (1/s)", "residual", "condition")
    unstable = {mode["mode"] for mode in data["unstable"]}
    for i, mode in enumerate(data["eigenvalues"]):
        table.add_row(
            str(i + 1),
            f"{mode['im'] / tau:.3f}",
            f"{mode['re']:+.3f}",
            f"{mode['residual']:.1e}",
            f"{mode['condition']:.1f}",
            style="bold red" if i in unstable else None,
        )
    console.print(table)
    typer.echo(data["window"]["evidence"])


def main() -> None:
    """Run a command; wrong input and failed convergence end in one line, not a traceback."""
    with one_voice(MPI.COMM_WORLD):
        app(standalone_mode=True)
