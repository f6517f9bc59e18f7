"""The command ``cea run``: one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from scenes.matrix_scene import MatrixScene


def run(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override, e.g. contacts.pad_disc.mu=0.3")
    ] = None,
    backend: Annotated[
        Literal["fe", "iga"] | None, typer.Option(help="Backend for every body.")
    ] = None,
    data: Annotated[
        str | None, typer.Option(help="Folder of the files that a scene of matrices names.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for result.json and all else.")] = Path(
        "results/run"
    ),
) -> None:
    """Run one scene and write its result.json."""
    from scenes.matrix_scene import is_of_matrices, load_matrices

    inputs = {"scene": scene, "set": set_ or [], "backend": backend}
    if is_of_matrices(scene):
        _refuse("backend", backend, "left out: a scene of matrices has no bodies")
        report_matrices(load_matrices(scene, set_ or (), data), out, {**inputs, "data": data})
        return
    _refuse("data", data, "left out: a scene of bodies reads no matrices")
    _run_bodies(scene, set_ or [], backend, out, inputs)


def _refuse(option: str, value: str | None, allowed: str) -> None:
    from cea.errors import InputError

    if value is not None:
        raise InputError(option, value, allowed)


def report_matrices(scene: "MatrixScene", out: Path, inputs: dict[str, Any]) -> None:
    """Run a scene of matrices, print its modes and write its result.json."""
    from cea.files import check_writable
    from comparisons.cli.output import console, print_modes
    from scenes.describe import save_result
    from scenes.matrix_run import run_matrices

    with console.status("reading matrices") as status:
        check_writable(out / "result.json", "out")
        result = run_matrices(scene, listener=status.update)
    file = save_result(result, out / "result.json", inputs=inputs)
    print_modes(result)
    for name in ("pictures", "paraview"):
        console.print(f"left out: {name} ({result.skipped[name]})")
    typer.echo(f"{result.dofs} dofs, {result.timer.total:.2f} s; {file}")


def _run_bodies(
    scene: str,
    set_: list[str],
    backend: Literal["fe", "iga"] | None,
    out: Path,
    inputs: dict[str, Any],
) -> None:
    """Run a scene of bodies and write its result.json, pictures and files for ParaView."""
    from cea.files import check_writable
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_modes, print_steady, print_stresses
    from scenes.describe import save_result
    from scenes.read import load_scene
    from scenes.results import ModesResult
    from scenes.run import run_scene

    with console.status("reading the scene") as status:
        chosen = load_scene(scene, set_, backend)
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
    file = save_result(result, out / "result.json", inputs=inputs, data=files)
    print_steady(result)
    if isinstance(result, ModesResult):
        print_modes(result)
    else:
        print_stresses(result)
    typer.echo(f"{result.system.size} dofs, {result.timer.total:.2f} s; {file}")
