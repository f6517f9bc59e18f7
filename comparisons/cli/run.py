"""The command ``cea run``: one scene."""

from pathlib import Path
from typing import Annotated, Literal

import typer


def run(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
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
    from cea.files import check_writable
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_modes, print_stresses
    from scenes.describe import save_result
    from scenes.read import load_scene
    from scenes.results import ModesResult
    from scenes.run import run_scene

    with console.status("reading the scene") as status:
        chosen = load_scene(scene, set_ or (), backend)
        check_writable(out / "result.json", "out")
        if chosen.output.pictures or chosen.output.paraview:
            need("pictures")
        result = run_scene(chosen, listener=lambda stage: status.update(stage))
        files = {}
        if chosen.output.pictures and isinstance(result, ModesResult):
            from scenes.pictures import draw_modes

            status.update("pictures")
            pictures = draw_modes(result, chosen.output.pictures, out, animated=True)
            files["pictures"] = [file.name for file in pictures]
        if chosen.output.paraview:
            from scenes.paraview import write_paraview

            status.update("files for ParaView")
            collections = write_paraview(result, chosen.output.paraview, out)
            files["paraview"] = [file.name for file in collections]
    inputs = {"scene": scene, "set": set_ or [], "backend": backend}
    file = save_result(result, out / "result.json", inputs=inputs, data=files)
    if isinstance(result, ModesResult):
        print_modes(result)
    else:
        print_stresses(result)
    typer.echo(f"{result.system.size} dofs, {result.timer.total:.2f} s; {file}")
