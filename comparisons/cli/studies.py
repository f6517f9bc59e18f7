"""Commands that run many scenes, a study each."""

from pathlib import Path
from typing import Annotated

import typer


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
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("results/accuracy"),
) -> None:
    """Measure the error of every method against run time, on problems with exact eigenvalues."""
    from comparisons.cli.options import need, refuse_with_redraw
    from comparisons.cli.progress import working

    need("pictures", "exact")
    from comparisons.accuracy import page
    from comparisons.accuracy.finest import run_finest
    from comparisons.accuracy.no_flutter import run_no_flutter
    from comparisons.accuracy.problems import PROBLEMS, problem
    from comparisons.accuracy.runner import run_study
    from comparisons.accuracy.study import FULL, QUICK
    from scenes.results.folder import check_out

    refuse_with_redraw(redraw, {"problems": problems, "quick": quick})
    check_out(out)
    with working("accuracy") as work:
        if redraw:
            data = page.read(out)
        else:
            names = [problem(name).name for name in problems or PROBLEMS]
            data = run_study(QUICK if quick else FULL, names, work.step)
        if finest:
            data["no_flutter"] = run_no_flutter(work.step)
            data["finest"] = run_finest(progress=work.step)
    typer.echo(f"The report to open: {page.write(data, out)}")
