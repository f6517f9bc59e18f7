"""The commands ``cea run`` and ``cea solve``: one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Option

from comparisons.cli.options import Data, OnBackend, Out, SceneName, Settings, load, need

if TYPE_CHECKING:
    from collections.abc import Mapping

    from comparisons.cli.output import Working
    from scenes import Result
    from scenes.spec.matrices import MatrixScene
    from scenes.spec.reading import OutputSpec, Scene

_Overwrite = Annotated[bool, Option("--overwrite", help="Replace the result of another scene.")]
_Report = Annotated[bool, Option("--report", help="Write report.html too.")]


def run(
    scene: SceneName,
    set_: Settings = None,
    backend: OnBackend = None,
    data: Data = None,
    out: Annotated[
        Path | None, Option(help="Folder of the result; results/NAME by default.")
    ] = None,
    overwrite: _Overwrite = False,
    report: _Report = False,
    explain: Annotated[bool, Option("--explain", help="Print why each part was left out.")] = False,
) -> None:
    """Run one scene and write its result.json."""
    from comparisons.cli.output import working
    from scenes.spec.body import file_name
    from scenes.spec.reading import Scene

    with working("reading the scene"):
        chosen = load(scene, set_, backend, data)
    inputs: dict[str, Any] = {"scene": scene, "set": set_ or [], "backend": backend}
    if not isinstance(chosen, Scene):
        inputs["data"] = data
    out = out or Path("results") / file_name(chosen.name)
    _run(chosen, out, inputs, overwrite=overwrite, report=report, explain=explain)


def solve(
    mass: Annotated[str, Option(help="File of M: .mat, .mtx, .mtx.gz, .npz, PETSc binary.")],
    stiffness: Annotated[str, Option(help="File of K; FILE.mat:NAME if it holds several.")],
    max_frequency: Annotated[float, Option(help="Upper end of the window (Hz).")],
    damping: Annotated[str | None, Option(help="File of C, with gyroscopic terms.")] = None,
    symmetric: Annotated[bool | None, Option(help="Mirror files that hold one triangle.")] = None,
    growth_threshold: Annotated[
        float | None, Option(help="Growth rate (1/s) above which modes are unstable.")
    ] = None,
    min_growth: Annotated[float | None, Option(help="Least growth rate (1/s) searched.")] = None,
    out: Out = Path("results/solve"),
    overwrite: _Overwrite = False,
    report: _Report = False,
) -> None:
    """Solve (lambda^2 M + lambda C + K) x = 0 for matrices from files."""
    from scenes.spec.matrices import read_matrix_scene

    roles = {"mass": mass, "stiffness": stiffness, "damping": damping}
    files = {role: file for role, file in roles.items() if file is not None}
    analysis = {
        "kind": "cea",
        "max_frequency": max_frequency,
        "growth_threshold": growth_threshold,
        "min_growth": min_growth,
    }
    data = {"name": "solve", "files": files, "analysis": analysis}
    sums = {role: {role: 1.0} for role in files}
    inputs: dict[str, Any] = {**roles, **analysis}
    if symmetric is not None:
        data["symmetric"] = dict.fromkeys(files, symmetric)
        inputs["symmetric"] = symmetric
    scene = read_matrix_scene(data | sums)
    _run(scene, out, inputs, overwrite=overwrite, report=report)


def _run(
    scene: "Scene | MatrixScene",
    out: Path,
    inputs: "Mapping[str, Any]",
    *,
    overwrite: bool,
    report: bool,
    explain: bool = False,
) -> None:
    """Run a scene, print its result, and replace an earlier one."""
    from comparisons.cli.output import console, print_result, say, working
    from scenes.results.folder import RESULT, check_run_out, new_folder
    from scenes.results.record import save_result
    from scenes.running.run import run_scene
    from scenes.spec.reading import OutputSpec

    output = getattr(scene, "output", OutputSpec())
    with working("") as work:
        check_run_out(out, inputs, overwrite=overwrite)
        if report or output.pictures or output.paraview:
            need("pictures")
        result = run_scene(scene, listener=work.stage)
    print_result(result, explain=explain)
    page = None
    with working("writing") as work, new_folder(out, root=result.comm.rank == 0) as new:
        drawn = _draw(result, output, new.part, work)
        record = save_result(result, new.part / RESULT, inputs=inputs, data=drawn)
        if report:
            from comparisons.run_report import write_run_report

            page = new.final(write_run_report(result, record))
    if new.kept:
        say(console, f"kept files that this program did not write: {', '.join(new.kept)}")
    typer.echo(f"{result.dofs} dofs, {result.timer.total:.2f} s; {out / RESULT}")
    if page:
        typer.echo(f"The page to open: {page}")


def _draw(
    result: "Result", output: "OutputSpec", folder: Path, work: "Working"
) -> dict[str, list[str]]:
    """Write the pictures and files for ParaView that a scene requests; return their names."""
    files: dict[str, list[Path]] = {}
    if output.pictures:
        from comparisons.contact_pictures import draw_contacts

        work.stage("pictures")
        files["pictures"] = draw_contacts(result, folder)
        if result.spectrum is not None:
            files["pictures"] += result.draw(output.pictures, folder)
    if output.paraview:
        from scenes.export.paraview import write_paraview

        work.stage("files for ParaView")
        files["paraview"] = write_paraview(result, output.paraview, folder)
    return {kind: [file.name for file in some] for kind, some in files.items()}
