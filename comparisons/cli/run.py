"""The command ``cea run``: one scene."""

from pathlib import Path
from typing import Annotated, Literal

import typer


def run(
    scene: Annotated[Path, typer.Argument(help="TOML file, or the name of a scene.")],
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override, e.g. contacts.pad_disc.mu=0.3")
    ] = None,
    backend: Annotated[
        Literal["fe", "iga"] | None, typer.Option(help="Backend for every body.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for result.json and all else.")] = Path(
        "results/run"
    ),
) -> None:
    """Run one scene and write its result.json."""
    from cea.petsc import MPI
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_modes, print_stresses
    from scenes.read import load_scene
    from scenes.results import describe, write_json
    from scenes.run import run_scene

    with console.status("reading the scene") as status:
        chosen = load_scene(scene, set_ or (), backend)
        if chosen.output.pictures or chosen.output.paraview:
            need("pictures")
        result = run_scene(chosen, listener=lambda stage: status.update(stage))
        data = describe(result)
        if chosen.output.pictures:
            from scenes.pictures import draw_modes

            status.update("pictures")
            pictures = draw_modes(result, chosen.output.pictures, out, animated=True)
            data["pictures"] = [file.name for file in pictures]
        if chosen.output.paraview:
            from scenes.paraview import write_paraview

            status.update("files for ParaView")
            collections = write_paraview(result, chosen.output.paraview, out)
            data["paraview"] = [file.name for file in collections]
    if MPI.COMM_WORLD.rank == 0:
        write_json(data, out / "result.json")
    if result.modes is not None:
        print_modes(data)
    if "stresses" in data:
        print_stresses(data)
    typer.echo(f"{data['dofs']['free']} dofs, {data['seconds']:.2f} s; {out / 'result.json'}")
