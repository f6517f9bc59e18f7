"""Commands that run many scenes, a study each."""

from pathlib import Path
from typing import Annotated

import typer


def compare(
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("results/compare"),
) -> None:
    """Run both scenes on both backends with every formulation and write the report."""
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_table

    need("pictures")
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
        print_table(make(data))
    typer.echo(f"The report to open: {report}")


def formulations(
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("results/formulations"),
) -> None:
    """Patch tests, locking, momentum, numbers of the paper, pairings of backends: one page."""
    from comparisons.cli.extras import need
    from comparisons.cli.output import console

    need("pictures", "exact")
    from comparisons.formulations.page import read_formulations, write_formulations
    from comparisons.formulations.study import run_formulations
    from comparisons.kit.progress import Progress
    from comparisons.paper.patch_test.numbers import run_paper_numbers

    with console.status("formulations") as status:
        if redraw:
            data = read_formulations(out)
        else:
            data = run_formulations(
                Progress(step=status.update, stage=lambda stage: None),
                lambda part: console.print(f"· {part}"),
                run_paper_numbers,
            )
        status.update("report")
        report = write_formulations(data, out)
    typer.echo(f"The report to open: {report}")


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
    from comparisons.cli.extras import need
    from comparisons.cli.output import console

    need("pictures", "exact")
    from comparisons.accuracy import page
    from comparisons.accuracy.finest import run_finest
    from comparisons.accuracy.no_flutter import run_no_flutter
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
            data["no_flutter"] = run_no_flutter(status.update)
            data["finest"] = run_finest(progress=status.update)
    typer.echo(f"The report to open: {page.write(data, out)}")


def damping(
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the figure and its table.")] = Path(
        "results/damping"
    ),
) -> None:
    """How damping moves the threshold of flutter: elastic bodies over the exact lumped system."""
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_table

    need("pictures", "exact")
    from comparisons.damping.report import read_damping, thresholds_table, write_damping
    from comparisons.damping.study import run_damping

    with console.status("damping") as status:
        data = read_damping(out) if redraw else run_damping(status.update)
        status.update("figure")
        figure = write_damping(data, out)
    print_table(thresholds_table(data))
    typer.echo(f"The figure to open: {figure}")


def stability(
    case: Annotated[
        list[str] | None, typer.Option("--case", help="Name of a case; may be repeated.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A few runs of each row: a minute instead of some.")
    ] = False,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the report.")] = Path("results/stability"),
) -> None:
    """Run stiff and extreme scenes against references; code 1 when one is not as expected."""
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_table

    need("pictures", "exact")
    from comparisons.stability.page import read_stability, write_stability
    from comparisons.stability.study import StabilityStudy, run_stability
    from comparisons.stability.tables import verdicts_table
    from comparisons.stability.words import summary

    with console.status("stability") as status:
        if redraw:
            data = read_stability(out)
        else:
            study = StabilityStudy(tuple(case or ()), quick)
            data = run_stability(study, lambda title: console.print(f"· {title}"))
        status.update("report")
        report = write_stability(data, out)
    print_table(verdicts_table(data))
    typer.echo(summary(data))
    typer.echo(f"The report to open: {report}")
    if data["failed"]:
        raise typer.Exit(1)


def reference(
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Run it anew (some minutes, 12 GB) and compare.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the reference and its table.")] = Path(
        "results/reference"
    ),
) -> None:
    """Show the converged modes of disc_pad, on which both backends agree."""
    from cea.petsc import MPI
    from comparisons.cli.output import console, print_table
    from comparisons.kit.progress import Progress
    from comparisons.reference.study import compute_reference, stored_reference
    from comparisons.reference.tables import reference_table
    from scenes.stored import write_record

    data = stored_reference()
    if recompute:
        with console.status("reference") as status:
            data = compute_reference(Progress(step=console.print, stage=status.update))
    table = reference_table(data)
    if MPI.COMM_WORLD.rank == 0:
        write_record(data, out / "disc_pad_reference.json")
        table.write_csv(out)
    print_table(table)
    typer.echo(f"{out / 'disc_pad_reference.json'}")
