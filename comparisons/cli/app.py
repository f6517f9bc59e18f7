"""The command line ``cea``: its commands, each a function that imports what it uses."""

import os
import sys
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import cea
from cea.errors import InputError
from comparisons.cli.bench import app as bench_app
from comparisons.cli.brake import brake
from comparisons.cli.converge import converge
from comparisons.cli.doctor import doctor
from comparisons.cli.exact import app as exact_app
from comparisons.cli.export import export
from comparisons.cli.paper import claims, figure
from comparisons.cli.peers import peers
from comparisons.cli.race import race
from comparisons.cli.ranks import launched_together, one_voice
from comparisons.cli.run import run
from comparisons.cli.scene import app as scene_app
from comparisons.cli.solve import solve
from comparisons.cli.studies import (
    accuracy,
    compare,
    damping,
    formulations,
    reference,
    stability,
)
from comparisons.cli.sweep import sweep, threshold


class _LightGroup(TyperGroup):
    """Commands whose help needs no pydantic.

    Typer brings it to find what an option means that is not given; ``--help`` then means no.
    """

    def get_help_option(self, ctx: Any) -> Any:
        """The option ``--help``, no by default."""
        option = super().get_help_option(ctx)
        if option is not None:
            option.default = False
        return option

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Arguments of a command, none of which is empty: an empty path would mean this folder."""
        for before, given in zip(["", *args], args, strict=False):
            name, equals, value = given.partition("=")
            if not given or (name.startswith("--") and equals and not value):
                option = name or (before if before.startswith("--") else "")
                raise InputError(option[2:] or "argument", "", "something that is not empty")
        return super().parse_args(ctx, args)


# Help is plain: help in colours takes as long as all else that `cea --help` does.
app = typer.Typer(
    cls=_LightGroup,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
_COMMANDS = (
    *(run, converge, solve, sweep, threshold, race, export),
    *(compare, figure, claims, formulations, accuracy, damping, stability, reference, peers),
    *(brake, doctor),
)
for _each in _COMMANDS:
    app.command()(_each)
app.add_typer(exact_app, name="exact")
app.add_typer(bench_app, name="bench")
app.add_typer(scene_app, name="scene")


def _tell_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        typer.echo(f"friction-cea {cea.__version__}")
        raise typer.Exit


@app.callback()
def _command(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_tell_version, is_eager=True, help="Tell the version."),
    ] = False,
) -> None:
    """Friction-induced flutter by complex eigenvalue analysis."""


def main() -> None:
    """Run a command; wrong input and failed convergence end in one line, not a traceback."""
    # Products of small matrices lose by threads, many times over on a machine that is busy.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(
                errors="replace"
            )  # marks and signs end no run where none can be shown
    with one_voice(launched_together()):
        app(standalone_mode=True)
