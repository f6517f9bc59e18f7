"""The commands ``cea bench``: what solving, assembling and more ranks cost."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from comparisons.cli.peers import peers
from comparisons.cli.race import race

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from comparisons.bench.report import Report
    from comparisons.kit.progress import Progress

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Time and memory beside other programs and methods, on this machine.",
)

app.command("matrices")(race)
app.command("calculix")(peers)

_REDRAW = "Draw the result in --out anew, run nothing."
_OUT = "Folder of the result."


@app.command()
def assembly(
    only: Annotated[
        list[str] | None,
        typer.Option("--only", help="Functions, as Q2, P3 or NURBS4; may be repeated."),
    ] = None,
    program: Annotated[
        list[str] | None,
        typer.Option("--program", help="Name of a program; may be repeated."),
    ] = None,
    boxes: Annotated[
        tuple[int, int, int], typer.Option(help="Elements along radius, angle and height.")
    ] = (16, 16, 8),
    repeats: Annotated[int, typer.Option(help="Rounds; medians count.")] = 3,
    seconds: Annotated[float, typer.Option(help="Longest time for one assembly (s).")] = 120.0,
    redraw: Annotated[bool, typer.Option("--redraw", help=_REDRAW)] = False,
    out: Annotated[Path, typer.Option(help=_OUT)] = Path("results/bench/assembly"),
) -> None:
    """Assemble a quarter ring by this program, by dolfinx alone and by those of the extra bench."""
    from comparisons.cli.options import need

    need("pictures")
    from comparisons.bench.assembly.page import REPORT
    from comparisons.bench.assembly.study import AssemblyStudy, run_assembly

    def run(progress: "Progress") -> "Iterator[dict[str, Any]]":
        study = AssemblyStudy(
            tuple(only or ()), tuple(program or ()), boxes, repeats=repeats, seconds=seconds
        )
        return run_assembly(study, progress)

    _shown(REPORT, run, out, redraw=redraw)


@app.command()
def solve(
    size: Annotated[str, typer.Option(help="Mesh: tiny, small, medium or large.")] = "medium",
    ranks: Annotated[int, typer.Option(help="Ranks of each method.")] = 1,
    repeats: Annotated[int, typer.Option(help="Runs of each by turns; medians count.")] = 1,
    seconds: Annotated[float, typer.Option(help="Longest time of a run (s).")] = 900.0,
    memory: Annotated[float, typer.Option(help="Most memory of each rank (10^9 bytes).")] = 8.0,
    redraw: Annotated[bool, typer.Option("--redraw", help=_REDRAW)] = False,
    out: Annotated[Path, typer.Option(help=_OUT)] = Path("results/bench/solve"),
) -> None:
    """Solve disc_pad by this driver, SLEPc alone, scipy, and projection on real modes."""
    from comparisons.cli.options import need

    need("pictures")
    from comparisons.bench.solve.page import REPORT
    from comparisons.bench.solve.study import SolveStudy, run_solve

    _shown(
        REPORT,
        lambda progress: [run_solve(SolveStudy(size, ranks, repeats, seconds, memory), progress)],
        out,
        redraw=redraw,
    )


@app.command()
def scaling(
    size: Annotated[str, typer.Option(help="Row of meshes: tiny, medium or large.")] = "medium",
    ranks: Annotated[
        list[int] | None, typer.Option("--ranks", help="Number of ranks; may be repeated.")
    ] = None,
    repeats: Annotated[int, typer.Option(help="Runs of each by turns; medians count.")] = 1,
    seconds: Annotated[float, typer.Option(help="Longest time of a run (s).")] = 900.0,
    redraw: Annotated[bool, typer.Option("--redraw", help=_REDRAW)] = False,
    out: Annotated[Path, typer.Option(help=_OUT)] = Path("results/bench/scaling"),
) -> None:
    """Run disc_pad on 1 and 2 ranks, or those of --ranks, on finer meshes, of higher degrees."""
    from comparisons.cli.options import need

    need("pictures")
    from comparisons.bench.scaling.page import REPORT
    from comparisons.bench.scaling.study import ScalingStudy, run_scaling

    def run(progress: "Progress") -> "Iterator[dict[str, Any]]":
        counts = tuple(ranks) if ranks else ScalingStudy.ranks
        return run_scaling(ScalingStudy(size, counts, repeats, seconds=seconds), progress)

    _shown(REPORT, run, out, redraw=redraw)


@app.command()
def contact(
    elements: Annotated[
        list[int] | None,
        typer.Option("--elements", help="Elements along a side; may be repeated."),
    ] = None,
    repeats: Annotated[int, typer.Option(help="Runs of each by turns; medians count.")] = 1,
    redraw: Annotated[bool, typer.Option("--redraw", help=_REDRAW)] = False,
    out: Annotated[Path, typer.Option(help=_OUT)] = Path("results/bench/contact"),
) -> None:
    """Search and assemble contacts of up to a million points, beside evaluating bases there."""
    from comparisons.bench.contact.page import REPORT
    from comparisons.bench.contact.study import ContactStudy, run_contact

    def run(progress: "Progress") -> "Iterator[dict[str, Any]]":
        counts = tuple(elements) if elements else ContactStudy.elements
        return run_contact(ContactStudy(counts, repeats), progress)

    _shown(REPORT, run, out, redraw=redraw)


def _shown(
    report: "Report",
    run: "Callable[[Progress], Iterable[dict[str, Any]]]",
    out: Path,
    *,
    redraw: bool,
) -> None:
    """Run a study, which gives its record as it grows, or read it; show it."""
    from cea.files import check_writable
    from comparisons.cli.output import console, print_table
    from comparisons.kit.progress import Progress

    if redraw:
        data = report.read(out)
        page = report.write(data, out)
    else:
        check_writable(out / "result.json", "out")
        with console.status(report.command) as status:
            for data in run(Progress(lambda name: console.print(f"· {name}"), status.update)):
                page = report.write(data, out)
    for make in report.tables:
        if (table := make(data)).rows:
            print_table(table)
    typer.echo(report.summary(data))
    typer.echo(f"The page to open: {page}")
