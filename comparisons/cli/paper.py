"""Figures of the paper, its numbers beside ours, and which of its claims hold."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

_Anew = Annotated[bool, typer.Option("--anew", help="Run every case, also stored ones.")]


def figure(
    names: Annotated[
        list[str], typer.Argument(help="Numbers of figures, studies by name, or all.")
    ],
    only: Annotated[
        list[str] | None,
        typer.Option(help="mesh=NURBS: what to compute; what is stored is shown too."),
    ] = None,
    anew: _Anew = False,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/figures"),
) -> None:
    """Make figures of the paper on every kind of mesh: data, pictures, its numbers beside ours."""
    from comparisons.cli.study import run_study, study_at

    _need_pictures()
    given = {"figures": () if names == ["all"] else tuple(names)}
    run_study(study_at(_STUDY), given, out=out, only=only, anew=anew)


def claims(
    anew: _Anew = False,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/claims"),
) -> None:
    """Judge the paper's claims by the numbers of all figures; what is not stored is computed."""
    from comparisons.cli.study import run_study, study_at

    _need_pictures()
    study = study_at(_STUDY)
    run_study(replace(study, sections=study.sections[:1]), {}, out=out, anew=anew)


_STUDY = "comparisons.paper.study:STUDY"


def _need_pictures() -> None:
    from comparisons.cli.options import need

    need("pictures")
