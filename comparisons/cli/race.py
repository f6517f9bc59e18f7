"""The command ``cea bench matrices``: run time beside scipy."""

from pathlib import Path
from typing import Annotated

import typer


def race(
    scene: Annotated[str, typer.Argument(help="Scene of matrices: TOML file, or its name.")],
    set_: Annotated[list[str] | None, typer.Option("--set", help="Override of a field.")] = None,
    data: Annotated[str | None, typer.Option(help="Folder of the files it names.")] = None,
    repeats: Annotated[int, typer.Option(help="Runs of each; the median counts.")] = 3,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/race"),
) -> None:
    """Time a scene of matrices beside five shift-and-invert runs of scipy in the same process."""
    from comparisons.cli.output import print_table
    from comparisons.cli.progress import working
    from comparisons.race.page import write_race
    from comparisons.race.study import race as run_race
    from comparisons.race.tables import race_table
    from scenes.results.folder import check_out, new_folder
    from scenes.spec.matrices import load_matrices

    with working("race") as work:
        chosen = load_matrices(scene, set_ or (), data)
        check_out(out)
        inputs = {"scene": scene, "set": set_ or [], "data": data, "repeats": repeats}
        found = run_race(chosen, inputs, repeats=repeats, progress=work.stage)
    with new_folder(out) as new:
        file = new.final(write_race(found, new.part))
    print_table(race_table(found))
    typer.echo(f"{file}")
