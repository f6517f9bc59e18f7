"""Commands of the paper: ``figure`` makes its figures, ``claims`` judges what it says."""

from pathlib import Path
from time import perf_counter
from typing import Annotated, Literal

import typer

_Out = Annotated[Path, typer.Option("--out", help="Folder of data, tables and pictures.")]


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
    from cea.petsc import MPI
    from comparisons.cli.options import need
    from comparisons.cli.output import print_table
    from comparisons.cli.progress import working

    need("pictures")
    from comparisons.kit.progress import Progress
    from comparisons.paper.both_backends import make_both
    from comparisons.paper.common.store import make_figure
    from comparisons.paper.registry import chosen
    from scenes.results.folder import check_out

    figures = chosen(name)
    check_out(out)
    for each in figures:
        with working(each.title) as work:
            progress = Progress(step=work.step, stage=lambda stage: None)
            pictures = []
            if backend == "both":
                both = make_both(each, out, progress, recompute=recompute)
                every, pictures = list(both.made.values()), both.pictures
            else:
                every = [make_figure(each, backend, out, progress, recompute=recompute)]
        for made in every:
            if MPI.COMM_WORLD.rank == 0:
                print_table(made.numbers)
                typer.echo(made.note)
            drawn = ", ".join(map(str, made.pictures))
            typer.echo(f"{'drawn from stored data' if made.reused else made.data_file}; {drawn}")
        if pictures:
            typer.echo(f"both: {', '.join(map(str, pictures))}")


def claims(out: _Out = Path("results/figures")) -> None:
    """Judge the paper's claims by the figures' data; what is not stored is computed."""
    from cea.petsc import MPI
    from comparisons.cli.options import need
    from comparisons.cli.progress import working

    need("pictures")
    from comparisons.kit.progress import Progress
    from comparisons.paper.claims.judge import judge, write_claims
    from scenes.results.folder import check_out

    check_out(out)
    start = perf_counter()
    with working("claims") as work:
        judged = judge(out, Progress(step=work.step, stage=lambda stage: None))
    if MPI.COMM_WORLD.rank == 0:
        for each in judged:
            typer.echo(each.told())
        typer.echo(", ".join(map(str, write_claims(judged, out, perf_counter() - start))))
