"""The command ``cea converge``: modes of a scene with error bars."""

from pathlib import Path
from time import perf_counter
from typing import Annotated, Literal

import typer

NOT_REACHED = 3
"""Exit code of a command that did not reach the digits asked for."""


def converge(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    digits: Annotated[int, typer.Option(help="Significant digits of frequencies.")] = 3,
    growth_digits: Annotated[
        int | None, typer.Option(help="Those of growth rates; one less by default.")
    ] = None,
    backend: Annotated[
        Literal["both", "fe", "iga"], typer.Option(help="Backends that are refined.")
    ] = "both",
    budget: Annotated[float, typer.Option(help="Seconds that all of it may take.")] = 900.0,
    unstable: Annotated[
        bool,
        typer.Option("--unstable", help="Only modes not known to be stable must hold digits."),
    ] = False,
    sweep_digits: Annotated[
        int, typer.Option(help="Digits that the mesh written for sweeps holds.")
    ] = 2,
    set_: Annotated[list[str] | None, typer.Option("--set", help="Override of a field.")] = None,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/converge"),
) -> None:
    """Refine a scene until its modes hold the digits asked for, and tell their error bars."""
    begun = perf_counter()
    from comparisons.cli.options import deliver, need, refuse_another, refuse_with_redraw
    from comparisons.cli.output import console, print_frame, print_warnings
    from comparisons.cli.progress import working
    from comparisons.converge.page import LEVELS, MODES, read_converge, write_converge
    from comparisons.converge.request import Request
    from comparisons.converge.study import run_converge
    from comparisons.study.progress import Progress
    from scenes.results.folder import check_out

    need("pictures")
    refuse_with_redraw(redraw, {"set": set_, "unstable": unstable})
    backends = None if backend == "both" else (backend,)
    request = Request(
        *(scene, digits, growth_digits, backends, budget, unstable, sweep_digits),
        tuple(set_ or ()),
    )
    if redraw:
        data = read_converge(out)
        refuse_another({"scene": scene}, data["inputs"])
        page = deliver(lambda folder: write_converge(data, folder), out)
        typer.echo(f"The page to open: {page}")
        return
    check_out(out)
    with working("converge") as work:

        def begin(name: str) -> None:
            console.print(f"· {name}", markup=False)
            work.step(name)

        data = run_converge(request, Progress(step=begin, stage=work.stage), begun)
        page = deliver(lambda folder: write_converge(data, folder), out)
    for line in (data["first"], data["words"], *data["hints"]):
        typer.echo(line)
    print_frame(MODES, data)
    print_frame(LEVELS, data)
    print_warnings(data["warnings"])
    typer.echo(f"The page to open: {page}")
    if not data["held"]:
        raise typer.Exit(NOT_REACHED)
