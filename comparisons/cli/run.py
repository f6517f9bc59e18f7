"""The command ``cea run``: one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from comparisons.cli.progress import Working
    from scenes import Result
    from scenes.spec.matrices import MatrixScene
    from scenes.spec.reading import Scene


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
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for result.json and all else; results/NAME by default."),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let go of another scene's result there.")
    ] = False,
    explain: Annotated[
        bool, typer.Option("--explain", help="Tell its steps and what is left out; run nothing.")
    ] = False,
    report: Annotated[
        bool, typer.Option("--report", help="Write report.html too: one file, to be played with.")
    ] = False,
) -> None:
    """Run one scene and write its result.json."""
    from comparisons.cli.explain import explain_bodies, explain_matrices
    from scenes.spec.files import is_of_matrices

    inputs = {"scene": scene, "set": set_ or [], "backend": backend}
    if is_of_matrices(scene):
        from scenes.spec.matrices import load_matrices

        _refuse("backend", backend, "left out: a scene of matrices has no bodies")
        if explain:
            explain_matrices(scene, set_ or [], data)
            return
        chosen = load_matrices(scene, set_ or (), data)
        inputs |= {"data": data}
        out = out or _results_of(chosen)
        report_matrices(chosen, out, inputs, overwrite, report=report)
        return
    _refuse("data", data, "left out: a scene of bodies reads no matrices")
    if explain:
        explain_bodies(scene, set_ or [], backend)
        return
    _run_bodies(inputs, out, overwrite, report=report)


def _results_of(scene: "Scene | MatrixScene") -> Path:
    """Folder of the results of a scene where none is given."""
    from scenes.spec.names import file_name

    return Path("results") / file_name(scene.name)


def _refuse(option: str, value: str | None, allowed: str) -> None:
    from cea.errors import InputError

    if value is not None:
        raise InputError(option, value, allowed)


def report_matrices(
    scene: "MatrixScene",
    out: Path,
    inputs: dict[str, Any],
    overwrite: bool,
    *,
    report: bool = False,
) -> None:
    """Run a scene of matrices, print its modes and write its result.json."""
    from comparisons.cli.extras import need
    from comparisons.cli.progress import working
    from comparisons.kit.records import last_seconds
    from scenes.results.folder import check_run_out
    from scenes.results.record import RUN
    from scenes.running.matrices import run_matrices

    expected = last_seconds(out, RUN, inputs)
    with working("reading matrices", expected=expected) as work:
        check_run_out(out, inputs, overwrite=overwrite)
        if report:
            need("pictures")
        result = run_matrices(scene, listener=work.stage)
    _write(result, out, inputs, report=report)


def _run_bodies(
    inputs: dict[str, Any],
    out: Path | None,
    overwrite: bool,
    *,
    report: bool,
) -> None:
    """Run a scene of bodies and write its result.json, pictures and files for ParaView."""
    from comparisons.cli.extras import need
    from comparisons.cli.progress import working
    from comparisons.kit.records import last_seconds
    from scenes import run_scene
    from scenes.results.folder import check_run_out
    from scenes.results.record import RUN
    from scenes.spec.reading import load_scene

    with working("reading the scene"):
        chosen = load_scene(inputs["scene"], inputs["set"], inputs["backend"])
    out = out or _results_of(chosen)
    with working("", expected=last_seconds(out, RUN, inputs)) as work:
        check_run_out(out, inputs, overwrite=overwrite)
        if chosen.output.pictures or chosen.output.paraview or report:
            need("pictures")
        result = run_scene(chosen, listener=work.stage)
    _write(result, out, inputs, report=report)


def _write(
    result: "Result",
    out: Path,
    inputs: dict[str, Any],
    *,
    report: bool,
) -> None:
    """Print a result, then put it in the place of an earlier one."""
    from comparisons.cli.output import console, print_result, say
    from comparisons.cli.progress import working
    from scenes import save_result
    from scenes.results.folder import RESULT, new_folder

    page = None
    print_result(result)
    with working("writing") as work, new_folder(out, root=result.comm.rank == 0) as new:
        drawn = {} if result.coupled is None else _draw(result, new.part, work)
        record = save_result(result, new.part / RESULT, inputs=inputs, data=drawn)
        if report:
            page = new.final(_report(result, record))
    if new.kept:
        say(console, f"not of this program, and kept: {', '.join(new.kept)}")
    typer.echo(f"{result.dofs} dofs, {result.timer.total:.2f} s; {out / RESULT}")
    if page:
        typer.echo(f"The report to open: {page}")


def _report(result: "Result", record: Path) -> Path:
    """Write the page of a run beside its record."""
    from comparisons.run_report.page import write_run_report

    return write_run_report(result, record)


def _draw(result: "Result", folder: Path, work: "Working") -> dict[str, list[str]]:
    """Write the pictures and files for ParaView that a scene asks for; their names."""
    files: dict[str, list[str]] = {}
    output = result.scene.output
    if output.pictures:
        from comparisons.kit.contact_pictures import draw_contacts

        work.stage("pictures")
        pictures = draw_contacts(result, folder)
        if result.spectrum is not None:
            from scenes.export.pictures import draw_modes

            pictures += draw_modes(result, output.pictures, folder, animated=True)
        files["pictures"] = [file.name for file in pictures]
    if output.paraview:
        from scenes.export.paraview import write_paraview
        from scenes.export.paraview_steps import write_load_steps

        work.stage("files for ParaView")
        collections = write_paraview(result, output.paraview, folder)
        collections += write_load_steps(result, folder)
        files["paraview"] = [file.name for file in collections]
    return files
