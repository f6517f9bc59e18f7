"""The command ``cea brake``: the ventilated brake on several meshes."""

from pathlib import Path
from typing import Annotated

import typer


def brake(
    size: Annotated[
        list[float] | None,
        typer.Option("--size", help="Edge length of elements (m), falling; may be repeated."),
    ] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override of a field of ventilated_brake.")
    ] = None,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/brake"),
) -> None:
    """Run ventilated_brake on three meshes, or those of --size, and with other stiffnesses."""
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_table

    need("pictures")
    from cea.files import check_writable
    from comparisons.brake import tables
    from comparisons.brake.page import read_brake, write_brake
    from comparisons.brake.study import BrakeStudy, run_brake
    from comparisons.kit.progress import Progress

    with console.status("brake") as status:
        if redraw:
            data = read_brake(out)
            figure = write_brake(data, out)
        else:
            check_writable(out / "result.json", "out")
            study = BrakeStudy(
                tuple(size) if size else BrakeStudy.sizes, overrides=tuple(set_ or ())
            )
            step = ""

            def begin(name: str) -> None:
                nonlocal step
                step = name
                console.print(f"· {name}")

            progress = Progress(begin, lambda stage: status.update(f"{step}: {stage}"))
            for data in run_brake(study, progress, out):
                figure = write_brake(data, out)
    for make in (
        tables.runs_table,
        tables.modes_table,
        tables.unstable_table,
        tables.stiffness_table,
    ):
        print_table(make(data))
    typer.echo(f"The figure to open: {figure}")
