"""Studies, benchmarks and figures of the paper: ``cea study``, ``bench``, ``paper``."""

from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import GenericAlias
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

import typer
from typer import Argument, Option

from cea.errors import require
from comparisons.cli.options import Anew, LazyGroup, command_with, group, need

if TYPE_CHECKING:
    from comparisons.study.result import StudyResult
    from comparisons.study.study import Study

STUDIES = {
    "agreement": ("agreement", "Both backends on disc and pad, in every pairing."),
    "accuracy": ("accuracy.study", "Error of every method against run time."),
    "patch_tests": ("patch_tests", "Patch tests of each formulation."),
    "locking": ("locking", "Which formulations lock as contact stiffness grows."),
    "stability": ("stability.study", "Stiff and extreme scenes against references."),
    "brake": ("brake.study", "A ventilated brake on several meshes."),
    "damping": ("damping", "Effect of damping on the flutter threshold."),
}
"""Module of each study below comparisons, and its help text."""
_BESIDE_EXACT = ("accuracy", "locking", "stability", "damping")  # need exact_cea
BENCHMARKS = {
    "assembly": ("bench.assembly", "Stiffness and mass, against dolfinx."),
    "solve": ("bench.solve", "Modes of disc_pad, against SLEPc, scipy, projection."),
    "scaling": ("bench.scaling", "More ranks and finer meshes."),
    "calculix": ("bench.calculix", "CalculiX on the same meshes."),
}
"""Benchmarks: time and memory on this machine, against other programs and methods."""

_COMMON: dict[str, tuple[Any, Any, str]] = {
    "quick": (bool, False, "Run a small part of it, in a minute or two."),
    "only": (list[str], None, "LABEL=VALUE of the cases to run; may be repeated."),
    "anew": (bool, False, "Run every case, also stored ones."),
    "redraw": (bool, False, "Redraw the result in --out, run nothing."),
}


def study_in(module: str) -> "Study":
    """The study of a module below comparisons."""
    return import_module(f"comparisons.{module}").STUDY


class Studies(LazyGroup):
    """A command for each study, whose module is imported when it is called."""

    table = STUDIES

    def make(self, name: str) -> Any:
        """The command of a study, with its own options and the common ones."""
        need("pictures", *(["exact"] if name in _BESIDE_EXACT else []))
        study = study_in(self.table[name][0])
        out = Path("results", *study.name.split())
        shown = _own_options(study) | _COMMON | {"out": (Path, out, "Folder of the result.")}

        def call(**given: Any) -> None:
            run_study(study, **given)

        call.__doc__ = f"{study.title}."
        return command_with(call, shown)


class Benchmarks(Studies):
    """A command for each benchmark."""

    table = BENCHMARKS


def _own_options(study: "Study") -> dict[str, tuple[Any, Any, str]]:
    """Options of a study that have a help text; if not given, the study's default is used."""
    hints = get_type_hints(study.options, include_extras=True)
    told = {name: get_args(hint) for name, hint in hints.items() if get_origin(hint) is Annotated}
    return {name: (_kind(hint), None, text) for name, (hint, text) in told.items()}


def _kind(hint: Any) -> Any:
    """Type of an option: a list for a tuple of any length."""
    parts = get_args(hint)
    any_length = get_origin(hint) is tuple and parts[-1] is Ellipsis
    return GenericAlias(list, (parts[0],)) if any_length else hint


def run_study(
    study: "Study",
    out: Path,
    *,
    quick: bool = False,
    only: list[str] | None = None,
    anew: bool = False,
    redraw: bool = False,
    **options: Any,
) -> None:
    """Run a study, or redraw its stored result; print its tables and the page to open."""
    from cea.petsc import MPI
    from comparisons.cli.options import refuse_with_redraw
    from comparisons.study.page import write_study
    from comparisons.study.result import read
    from comparisons.study.run import finished
    from scenes.results.folder import check_out, new_folder

    given = {name: value for name, value in options.items() if value not in (None, [])}
    refuse_with_redraw(redraw, {"quick": quick, "only": only, "anew": anew, **given})
    if redraw:
        result = read(study.name, out)
    else:
        check_out(out)
        result = _run(study, given, out, quick, only or [], anew)
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        page = write_study(study, result, new.part) if MPI.COMM_WORLD.rank == 0 else None
    if page is None:
        return
    finished(out)
    _print(study, result)
    typer.echo(f"The page to open: {new.final(page)}")
    fault = study.check(result) if study.check else ""
    if fault:
        typer.echo(fault, err=True)
        raise typer.Exit(1)


def _run(
    study: "Study", given: dict[str, Any], out: Path, quick: bool, only: list[str], anew: bool
) -> "StudyResult":
    from comparisons.cli.output import working
    from comparisons.study.run import run, selected
    from comparisons.study.session import Progress

    for each in only:
        require("=" in each, "only", each, "LABEL=VALUE")
    labels = dict(each.split("=", 1) for each in only)
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in given.items()}
    options = study.options(**{**(study.quick if quick else {}), **values})
    with working(study.name, steps=len(selected(study, options, labels))) as work:
        progress = Progress(step=work.step, stage=work.stage)
        return run(study, options, out, anew=anew, only=labels, progress=progress)


def _print(study: "Study", result: "StudyResult") -> None:
    """Print headlines, the tables marked ``printed``, and the number of failed cases."""
    from comparisons.cli.output import print_frame
    from comparisons.study.page import present

    for section in present(study.sections, result):
        headline = section.headline(result) if section.headline else None
        if headline:
            typer.echo(headline)
        for table in section.tables:
            if table.printed:
                print_frame(table, result)
    failed = len(result.failed())
    if failed:
        typer.echo(f"{failed} of {len(result.cases)} cases failed: see the report")


app = group("Run a study: cases, their tables and plots on one page.", Studies)
bench = group("Compare time and memory with other programs and methods.", Benchmarks)


def paper(
    names: Annotated[
        list[str] | None, Argument(help="Figures by number or name; all; or claims alone.")
    ] = None,
    only: Annotated[list[str] | None, Option(help="Cases to compute, e.g. mesh=NURBS.")] = None,
    anew: Anew = False,
    out: Annotated[
        Path | None, Option(help="Folder of the result: results/paper, or results/claims.")
    ] = None,
) -> None:
    """Make figures of the paper on every kind of mesh, and check its claims by their numbers."""
    need("pictures")
    made, chosen = study_in("paper.study"), () if names in (None, ["all"]) else tuple(names)
    if chosen == ("claims",):
        made, chosen = replace(made, sections=made.sections[:1]), ()
        out = out or Path("results/claims")
    out = out or Path("results/paper")
    run_study(made, out, only=only, anew=anew, figures=list(chosen))
