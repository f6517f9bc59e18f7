"""The command ``cea sweep``: one scene along one of its fields."""

from pathlib import Path
from typing import Annotated

import typer


def sweep(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    field: Annotated[str, typer.Argument(help="Field that is changed, e.g. parameters.Omega.")],
    start: Annotated[float, typer.Argument(help="Its first value.")],
    stop: Annotated[float, typer.Argument(help="Its last value.")],
    points: Annotated[int, typer.Option(help="Number of values.")] = 13,
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override of another field.")
    ] = None,
    data: Annotated[
        str | None, typer.Option(help="Folder of the files that a scene of matrices names.")
    ] = None,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/sweep"),
) -> None:
    """Follow the modes of a scene along a field, and draw those that become unstable."""
    from comparisons.cli.extras import need
    from comparisons.cli.output import print_table
    from comparisons.cli.progress import working
    from comparisons.cli.redraw import refuse_another, refuse_with_redraw

    need("pictures")
    from cea.petsc import MPI
    from comparisons.sweep.page import read_sweep, write_sweep
    from comparisons.sweep.study import Sweep, run_sweep
    from comparisons.sweep.tables import unstable_table, values_table
    from scenes.out_folder import check_out, new_folder

    refuse_with_redraw(redraw, {"set": set_, "data": data})
    if redraw:
        found = read_sweep(out)
        asked_for = {"scene": scene, "field": field, "start": start, "stop": stop}
        refuse_another(asked_for, found["inputs"])
    else:
        asked = Sweep(scene, field, start, stop, points, tuple(set_ or ()), data)
        check_out(out)
        with working("sweep", steps=points) as work:
            found = run_sweep(asked, work.step)
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        picture = new.final(write_sweep(found, new.part))
    print_table(values_table(found))
    print_table(unstable_table(found))
    typer.echo(f"The picture to open: {picture}")
