"""Studies, benchmarks and figures of the paper: ``cea study, bench, figure, claims``.

Options of a study are the fields of a dataclass.
"""

import inspect
import re
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

import typer

from cea.errors import InputError
from comparisons.cli.options import PLAIN, Anew, LazyGroup, Out, command_with, need

if TYPE_CHECKING:
    from comparisons.study.result import StudyResult
    from comparisons.study.study import Study

STUDIES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "agreement": ("agreement:STUDY", "Both backends on disc and pad, in every pairing.", ()),
    "accuracy": ("accuracy.study:STUDY", "Error of every method against run time.", ("exact",)),
    "formulations": (
        *("formulations.study:STUDY", "Which formulations pass patch tests, lock, keep momentum."),
        ("exact",),
    ),
    "stability": (
        *("stability.study:STUDY", "Stiff and extreme scenes beside references."),
        ("exact",),
    ),
    "brake": ("brake.study:STUDY", "A ventilated brake on several meshes.", ()),
    "damping": ("damping:STUDY", "How damping moves the threshold of flutter.", ("exact",)),
}
"""Place of each study below comparisons, its help, and the extras that it needs beside pictures."""
BENCHMARKS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "assembly": ("bench.assembly:STUDY", "Stiffness and mass, beside dolfinx.", ()),
    "solve": ("bench.solve:STUDY", "Modes of disc_pad, beside SLEPc, scipy, projection.", ()),
    "scaling": ("bench.scaling:STUDY", "More ranks and finer meshes.", ()),
    "matrices": ("bench.matrices:STUDY", "Matrices from files, beside scipy.", ()),
    "calculix": ("bench.calculix:STUDY", "CalculiX on the same meshes.", ()),
}
"""Benchmarks: time and memory beside other programs and methods, on this machine."""

_COMMON: dict[str, tuple[Any, Any, str]] = {
    "quick": (bool, False, "A small part of it, in a minute or two."),
    "only": (list[str], None, "LABEL=VALUE of the cases to run; may be repeated."),
    "anew": (bool, False, "Run every case, also those that are stored."),
    "redraw": (bool, False, "Run nothing: draw the result in --out anew."),
}


def study_at(place: str) -> "Study":
    """The study that a name of a module and of a variable gives."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


class Studies(LazyGroup):
    """Commands by name of the study; the module of one is imported when it is called."""

    table = STUDIES

    def helps(self) -> dict[str, str]:
        """Help of each study."""
        return {name: help for name, (_, help, _) in self.table.items()}

    def make(self, name: str) -> Any:
        """Command of a study."""
        place, _, extras = self.table[name]
        need("pictures", *extras)
        return command_of(f"comparisons.{place}")


class Benchmarks(Studies):
    """Benchmarks by name."""

    table = BENCHMARKS


def command_of(place: str) -> Any:
    """Command with the options of a study and those that all have."""
    study = study_at(place)
    help_of, hints = _described(study.options), get_type_hints(study.options)
    shown: dict[str, tuple[Any, Any, str]] = {
        f.name: (*_option(hints[f.name]), help_of.get(f.name, ""))
        for f in fields(study.options)
        if _option(hints[f.name])[0] is not None
    }
    out = Path("results", *study.name.split())
    shown |= _COMMON | {"out": (Path, out, "Folder of the result.")}

    def call(**given: Any) -> None:
        common = {name: given.pop(name) for name in (*_COMMON, "out")}
        run_study(study, {name: v for name, v in given.items() if v not in (None, [])}, **common)

    call.__doc__ = f"{study.title}."
    return command_with(call, shown)


def _option(hint: Any) -> tuple[Any, Any]:
    """Type of an option and its default, None where the study's own stands; no type, no option."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is UnionType and type(None) in parts:
        return _option(next(part for part in parts if part is not type(None)))
    if origin is tuple and len(parts) == 2 and parts[1] is Ellipsis:
        kind = _option(parts[0])[0]
        lists = {int: list[int], float: list[float], str: list[str]}
        return lists.get(kind), None
    if origin is tuple:
        return hint, None
    if hint is bool:
        return bool, None
    return (hint if hint in (int, float, str) else None), None


def _described(options: type) -> dict[str, str]:
    """Help of the fields, from the numpy docstring of the options."""
    text = inspect.getdoc(options) or ""
    found = re.findall(r"^(\w+(?:, \w+)*)\n((?:    .*\n?)+)", text, re.MULTILINE)
    return {n: " ".join(body.split()) for names, body in found for n in names.split(", ")}


def run_study(
    study: "Study",
    given: dict[str, Any],
    *,
    out: Path,
    quick: bool = False,
    only: list[str] | None = None,
    anew: bool = False,
    redraw: bool = False,
) -> None:
    """Run a study, or draw it anew; print its tables and name the report to open."""
    from cea.petsc import MPI
    from comparisons.cli.options import refuse_with_redraw
    from comparisons.study.page import write_study
    from comparisons.study.result import read
    from comparisons.study.run import finished
    from scenes.results.folder import check_out, new_folder

    if redraw:
        refuse_with_redraw(True, {"quick": quick, "only": only, "anew": anew, **given})
        result = read(study.name, out)
    else:
        check_out(out)
        result = _run(study, given, out, quick, _labels(only or []), anew)
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
    study: "Study", given: dict[str, Any], out: Path, quick: bool, only: dict[str, str], anew: bool
) -> "StudyResult":
    from comparisons.cli.output import working
    from comparisons.study.progress import Progress
    from comparisons.study.run import run, selected

    values = {name: tuple(v) if isinstance(v, list) else v for name, v in given.items()}
    options = study.options(**{**(study.quick if quick else {}), **values})
    with working(study.name, steps=len(selected(study, options, only))) as work:
        progress = Progress(step=work.step, stage=work.stage)
        return run(study, options, out, anew=anew, only=only, progress=progress)


def _print(study: "Study", result: "StudyResult") -> None:
    """Print headlines, the tables that are for it, and how many cases failed."""
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


def _labels(only: list[str]) -> dict[str, str]:
    for each in only:
        if "=" not in each:
            raise InputError("only", each, "LABEL=VALUE")
    return dict(each.split("=", 1) for each in only)


app = typer.Typer(cls=Studies, no_args_is_help=True, **PLAIN)


@app.callback()
def study() -> None:
    """Run a study: cases, their tables and plots on one page."""


bench = typer.Typer(cls=Benchmarks, no_args_is_help=True, **PLAIN)


@bench.callback()
def _bench() -> None:
    """Time and memory beside other programs and methods, on this machine."""


_PAPER = "comparisons.paper.study:STUDY"


def figure(
    names: Annotated[
        list[str], typer.Argument(help="Numbers of figures, studies by name, or all.")
    ],
    only: Annotated[
        list[str] | None,
        typer.Option(help="mesh=NURBS: what to compute; what is stored is shown too."),
    ] = None,
    anew: Anew = False,
    out: Out = Path("results/figures"),
) -> None:
    """Make figures of the paper on every kind of mesh: data, pictures, its numbers beside ours."""
    need("pictures")
    given = {"figures": () if names == ["all"] else tuple(names)}
    run_study(study_at(_PAPER), given, out=out, only=only, anew=anew)


def claims(anew: Anew = False, out: Out = Path("results/claims")) -> None:
    """Judge the paper's claims by the numbers of all figures; what is not stored is computed."""
    need("pictures")
    paper = study_at(_PAPER)
    run_study(replace(paper, sections=paper.sections[:1]), {}, out=out, anew=anew)
