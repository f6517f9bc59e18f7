"""The command ``cea run``: one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from scenes.matrix_run import MatrixResult
    from scenes.matrix_scene import MatrixScene
    from scenes.results import ModesResult, StaticResult


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
    explain: Annotated[
        bool, typer.Option("--explain", help="Tell its steps and what is left out; run nothing.")
    ] = False,
    report: Annotated[
        bool, typer.Option("--report", help="Write report.html too: one file, to be played with.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder for result.json and all else.")] = Path(
        "results/run"
    ),
) -> None:
    """Run one scene and write its result.json."""
    from comparisons.cli.explain import explain_bodies, explain_matrices
    from scenes.matrix_scene import is_of_matrices, load_matrices

    inputs = {"scene": scene, "set": set_ or [], "backend": backend}
    if is_of_matrices(scene):
        _refuse("backend", backend, "left out: a scene of matrices has no bodies")
        if explain:
            explain_matrices(scene, set_ or [], data)
            return
        chosen = load_matrices(scene, set_ or (), data)
        report_matrices(chosen, out, {**inputs, "data": data}, report=report)
        return
    _refuse("data", data, "left out: a scene of bodies reads no matrices")
    if explain:
        explain_bodies(scene, set_ or [], backend)
        return
    _run_bodies(scene, set_ or [], backend, out, inputs, report=report)


def _refuse(option: str, value: str | None, allowed: str) -> None:
    from cea.errors import InputError

    if value is not None:
        raise InputError(option, value, allowed)


def report_matrices(
    scene: "MatrixScene", out: Path, inputs: dict[str, Any], *, report: bool = False
) -> None:
    """Run a scene of matrices, print its modes and write its result.json."""
    from cea.files import check_writable
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_modes
    from scenes.describe import save_result
    from scenes.matrix_run import run_matrices

    with console.status("reading matrices") as status:
        check_writable(out / "result.json", "out")
        if report:
            need("pictures")
        result = run_matrices(scene, listener=status.update)
    file = save_result(result, out / "result.json", inputs=inputs)
    print_modes(result)
    for name in ("pictures", "paraview"):
        console.print(f"left out: {name} ({result.skipped[name]})")
    typer.echo(f"{result.size} dofs, {result.timer.total:.2f} s; {file}")
    if report:
        _write_report(result, file)


def _run_bodies(
    scene: str,
    set_: list[str],
    backend: Literal["fe", "iga"] | None,
    out: Path,
    inputs: dict[str, Any],
    *,
    report: bool,
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
        if chosen.output.pictures or chosen.output.paraview or report:
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
    if report:
        _write_report(result, file)


def _write_report(result: "ModesResult | StaticResult | MatrixResult", file: Path) -> None:
    """Write the page of a run beside its record, and name it."""
    from comparisons.run_report.page import write_run_report

    typer.echo(f"The report to open: {write_run_report(result, file)}")
