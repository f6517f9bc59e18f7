"""The command ``cea solve``: modes of matrices given as files."""

from pathlib import Path
from typing import Annotated, Any

import typer


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
    out: Annotated[Path, typer.Option(help="Folder for result.json.")] = Path("results/solve"),
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let go of a result of other matrices there.")
    ] = False,
    report: Annotated[
        bool, typer.Option("--report", help="Write report.html too: one file, to be played with.")
    ] = False,
) -> None:
    """Solve (lambda^2 M + lambda C + K) x = 0 for matrices from files."""
    from comparisons.cli.run import report_matrices
    from scenes.spec.matrices import read_matrix_scene

    files = {"M": mass, "K": stiffness} | ({"C": damping} if damping is not None else {})
    analysis = {
        "kind": "cea",
        "max_frequency": max_frequency,
        "growth_threshold": growth_threshold,
        "min_growth": min_growth,
    }
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
    given: dict[str, Any] = {"mass": mass, "damping": damping, "stiffness": stiffness}
    if symmetric is not None:
        given["symmetric"] = symmetric
    report_matrices(scene, out, {**given, **analysis}, overwrite, report=report)
