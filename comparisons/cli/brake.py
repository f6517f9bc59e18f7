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
    from comparisons.cli.progress import working
    from comparisons.cli.redraw import refuse_with_redraw

    need("pictures")
    from comparisons.brake import tables
    from comparisons.brake.page import read_brake, write_brake
    from comparisons.brake.study import BrakeStudy, run_brake
    from comparisons.kit.progress import Progress
    from scenes.out_folder import check_out

    refuse_with_redraw(redraw, {"size": size, "set": set_})
    if redraw:
        data = read_brake(out)
        figure = write_brake(data, out)
    else:
        check_out(out)
        study = BrakeStudy(tuple(size or BrakeStudy.sizes), overrides=tuple(set_ or ()))
        with working("brake") as work:

            def begin(name: str) -> None:
                console.print(f"· {name}")
                work.step(name)

            for data in run_brake(study, Progress(step=begin, stage=work.stage), out):
                figure = write_brake(data, out)
    for make in (
        tables.runs_table,
        tables.modes_table,
        tables.unstable_table,
        tables.stiffness_table,
    ):
        print_table(make(data))
    typer.echo(f"The figure to open: {figure}")
