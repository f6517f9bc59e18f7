"""The commands ``cea run`` and ``cea solve``: one scene."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from comparisons.cli.options import Data, OnBackend, Out, SceneName, Settings, need, refuse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from comparisons.cli.output import Working
    from scenes import Result
    from scenes.spec.matrices import MatrixScene
    from scenes.spec.reading import Scene

_Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Let go of another scene's result there.")
]
_Report = Annotated[
    bool, typer.Option("--report", help="Write report.html too: one file, to be played with.")
]


def run(
    scene: SceneName,
    set_: Settings = None,
    backend: OnBackend = None,
    data: Data = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for result.json and all else; results/NAME by default."),
    ] = None,
    overwrite: _Overwrite = False,
    report: _Report = False,
    explain: Annotated[
        bool, typer.Option("--explain", help="Tell why each thing was left out.")
    ] = False,
) -> None:
    """Run one scene and write its result.json."""
    from comparisons.cli.output import working
    from scenes.spec.body import file_name
    from scenes.spec.plain import is_of_matrices

    inputs: dict[str, Any] = {"scene": scene, "set": set_ or [], "backend": backend}
    chosen: Scene | MatrixScene
    if is_of_matrices(scene):
        from scenes.spec.matrices import load_matrices

        refuse({"backend": backend}, "of a scene of matrices, which has no bodies")
        chosen = load_matrices(scene, set_ or (), data)
        inputs["data"] = data
    else:
        from scenes.spec.reading import load_scene

        refuse({"data": data}, "of a scene of bodies, which reads no matrices")
        with working("reading the scene"):
            chosen = load_scene(scene, set_ or (), backend)
    out = out or Path("results") / file_name(chosen.name)
    _run(chosen, out, inputs, overwrite=overwrite, report=report, explain=explain)


def solve(
    mass: Annotated[str, typer.Option(help="File of M: .mat, .mtx, .mtx.gz, .npz, PETSc binary.")],
    stiffness: Annotated[str, typer.Option(help="File of K, FILE.mat:NAME where it holds more.")],
    max_frequency: Annotated[float, typer.Option(help="Upper end of the window (Hz).")],
    damping: Annotated[
        str | None, typer.Option(help="File of C, damping and gyroscopic parts alike.")
    ] = None,
    symmetric: Annotated[
        bool | None,
        typer.Option(help="Mirror files of one triangle, or take them as they are."),
    ] = None,
    growth_threshold: Annotated[
        float | None,
        typer.Option(help="Growth rate (1/s) above which a mode is unstable; 1e-4 of |lambda|."),
    ] = None,
    min_growth: Annotated[
        float | None,
        typer.Option(help="Growth rate (1/s), zero or less, down to which damped modes count."),
    ] = None,
    out: Out = Path("results/solve"),
    overwrite: _Overwrite = False,
    report: _Report = False,
) -> None:
    """Solve (lambda^2 M + lambda C + K) x = 0 for matrices from files."""
    from scenes.spec.matrices import read_matrix_scene

    files = {"M": mass, "K": stiffness} | ({"C": damping} if damping is not None else {})
    limits = {"growth_threshold": growth_threshold, "min_growth": min_growth}
    analysis = {"kind": "cea", "max_frequency": max_frequency, **limits}
    scene = read_matrix_scene(
        {
            "name": "solve",
            "files": files,
            "symmetric": None if symmetric is None else dict.fromkeys(files, symmetric),
            "mass": {"M": 1.0},
            "damping": {"C": 1.0} if damping is not None else {},
            "stiffness": {"K": 1.0},
            "analysis": analysis,
        }
    )
    inputs: dict[str, Any] = {"mass": mass, "damping": damping, "stiffness": stiffness}
    if symmetric is not None:
        inputs["symmetric"] = symmetric
    _run(scene, out, {**inputs, **analysis}, overwrite=overwrite, report=report)


def _run(
    scene: "Scene | MatrixScene",
    out: Path,
    inputs: "Mapping[str, Any]",
    *,
    overwrite: bool,
    report: bool,
    explain: bool = False,
) -> None:
    """Run a scene, print its result, then put it in the place of an earlier one."""
    from comparisons.cli.output import console, print_result, say, working
    from scenes.results.folder import RESULT, check_run_out, new_folder
    from scenes.results.record import save_result
    from scenes.running.analysis import run_scene

    output = getattr(scene, "output", None)
    with working("") as work:
        check_run_out(out, inputs, overwrite=overwrite)
        if report or (output is not None and (output.pictures or output.paraview)):
            need("pictures")
        result = run_scene(scene, listener=work.stage)
    print_result(result, explain=explain)
    page = None
    with working("writing") as work, new_folder(out, root=result.comm.rank == 0) as new:
        drawn = {} if output is None else _draw(result, new.part, work)
        record = save_result(result, new.part / RESULT, inputs=inputs, data=drawn)
        if report:
            from comparisons.run_report import write_run_report

            page = new.final(write_run_report(result, record))
    if new.kept:
        say(console, f"not of this program, and kept: {', '.join(new.kept)}")
    typer.echo(f"{result.dofs} dofs, {result.timer.total:.2f} s; {out / RESULT}")
    if page:
        typer.echo(f"The page to open: {page}")


def _draw(result: "Result", folder: Path, work: "Working") -> dict[str, list[str]]:
    """Write the pictures and files for ParaView that a scene asks for; their names."""
    files: dict[str, list[Path]] = {}
    output = result.scene.output
    if output.pictures:
        from comparisons.contact_pictures import draw_contacts

        work.stage("pictures")
        files["pictures"] = draw_contacts(result, folder)
        if result.spectrum is not None:
            files["pictures"] += result.draw(output.pictures, folder)
    if output.paraview:
        from scenes.export.paraview import write_load_steps, write_paraview

        work.stage("files for ParaView")
        files["paraview"] = write_paraview(result, output.paraview, folder)
        files["paraview"] += write_load_steps(result, folder)
    return {kind: [file.name for file in some] for kind, some in files.items()}
