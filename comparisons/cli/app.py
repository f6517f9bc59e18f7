"""The command line ``cea``: its commands, each a function that imports what it uses."""

import os
import sys
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

import cea
from cea.errors import InputError
from comparisons.cli.options import PLAIN
from comparisons.cli.ranks import launched_together, one_voice

COMMANDS = {
    "run": ("run:run", "Run one scene and write its result.json."),
    "converge": ("sweep:converge", "Refine a scene until its modes hold the digits asked for."),
    "solve": ("run:solve", "Solve (lambda^2 M + lambda C + K) x = 0 for matrices from files."),
    "sweep": ("sweep:sweep", "Follow the modes of a scene along its fields: what grows where."),
    "threshold": ("sweep:threshold", "Find where flutter begins and ends along a field."),
    "study": ("study:app", "Run a study: both backends, formulations, accuracy, damping, ..."),
    "figure": ("study:figure", "Make a figure of the paper."),
    "claims": ("study:claims", "Judge the paper's claims by the figures' data."),
    "bench": ("study:bench", "Time and memory beside other programs and methods."),
    "scene": ("scene:app", "Look at scenes without running them."),
    "exact": ("exact:app", "Exact eigenvalues of frictional contacts."),
    "doctor": ("doctor:doctor", "Tell whether this installation works, and what mends it."),
}
"""Place of each command below this package, and its help."""
RENAMED = {
    "accuracy": "study accuracy",
    "brake": "study brake",
    "damping": "study damping",
    "stability": "study stability",
    "compare": "study agreement",
    "export": "scene export",
    "formulations": "study formulations",
    "peers": "bench calculix",
    "race": "bench matrices",
    "reference": "converge disc_pad",
}
"""Commands under the names that they had, and what they are called now."""


class _LightGroup(TyperGroup):
    """Commands whose modules are imported when they are called, and whose help needs no pydantic.

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

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, name: str) -> Any:
        """A command, imported now."""
        if name in RENAMED:
            raise InputError("command", name, f"its new name: cea {RENAMED[name]}")
        if name not in COMMANDS:
            return None
        module, _, attribute = COMMANDS[name][0].partition(":")
        found = getattr(import_module(f"comparisons.cli.{module}"), attribute)
        if isinstance(found, typer.Typer):
            return get_command(found)
        alone = typer.Typer(**PLAIN)
        alone.command(name)(found)
        return get_command(alone)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write names and help of the commands, whose modules need not be known for that."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, help) for name, (_, help) in COMMANDS.items()])


app = typer.Typer(cls=_LightGroup, no_args_is_help=True, pretty_exceptions_enable=False, **PLAIN)


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
            stream.reconfigure(errors="replace")  # signs that none can show end no run
    with one_voice(launched_together()):
        app(standalone_mode=True)
