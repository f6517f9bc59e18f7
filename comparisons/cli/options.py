"""Options that several commands share, and functions that handle them."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from typer import Argument, Option
from typer.core import TyperGroup
from typer.main import get_command

from cea.errors import require

if TYPE_CHECKING:
    from scenes.spec.matrices import MatrixScene
    from scenes.spec.reading import Scene

Backend = Literal["fe", "iga"]

SceneName = Annotated[str, Argument(help="TOML file, or the name of a scene.")]
Settings = Annotated[list[str] | None, Option("--set", help="Set, e.g., contacts.pad_disc.mu=0.3")]
OnBackend = Annotated[Backend | None, Option(help="Backend for every body.")]
Data = Annotated[str | None, Option(help="Folder of the files that a scene of matrices names.")]
Out = Annotated[Path, Option(help="Folder of the result.")]
Redraw = Annotated[bool, Option("--redraw", help="Redraw the result in --out, run nothing.")]
Anew = Annotated[bool, Option("--anew", help="Run every case, also stored ones.")]

PLAIN: Mapping[str, Any] = {"add_completion": False, "rich_markup_mode": None}
"""Options of every group; coloured help would double the time of `cea --help`."""

_MODULES = {
    "pictures": ("matplotlib", "PIL", "plotly", "pyvista"),
    "maps": ("h5netcdf", "xarray"),
    "exact": ("flint",),
}
"""Modules that each extra of `pyproject.toml` installs."""


class LazyGroup(TyperGroup):
    """Commands that are made when they are called, and listed without being made."""

    table: Mapping[str, tuple[Any, str]] = {}
    """Specification of each command by its name, and its help text."""

    def make(self, name: str) -> Any:
        """Return a command: a function, a group of Typer, or one of click."""
        raise NotImplementedError

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands."""
        return list(self.table)

    def get_command(self, ctx: Any, name: str) -> Any:
        """Make a command; None if there is none of this name."""
        if name not in self.table:
            return None
        made = self.make(name)
        if inspect.isfunction(made):
            alone = typer.Typer(**PLAIN)
            alone.command(name)(made)
            made = alone
        return get_command(made) if isinstance(made, typer.Typer) else made

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write names and help."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in self.table.items()])


def group(text: str, cls: type[TyperGroup] = TyperGroup) -> typer.Typer:
    """Return a group of commands with a help text."""
    made = typer.Typer(cls=cls, no_args_is_help=True, help=text, **PLAIN)
    made.callback()(lambda: None)
    return made


def need(*extras: str) -> None:
    """Raise an error with the command that installs them if extras are not installed.

    Extras are ``pictures``, ``maps`` and ``exact``.
    """
    for extra in extras:
        missing = ", ".join(module for module in _MODULES[extra] if find_spec(module) is None)
        allowed = f"installed, by python -m pip install 'friction-cea[{extra}]'"
        require(not missing, "modules", missing, allowed)


def command_with(
    call: Callable[..., None], options: Mapping[str, tuple[Any, Any, str]], name: str | None = None
) -> Any:
    """Return a command with an option for each name: its type, default and help."""
    one, parameters = typer.Typer(**PLAIN), []
    for option, (kind, default, text) in options.items():
        given = Option(default, f"--{option.replace('_', '-')}", help=text)
        only = inspect.Parameter.KEYWORD_ONLY
        parameters.append(inspect.Parameter(option, only, annotation=kind, default=given))
    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {option: kind for option, (kind, _, _) in options.items()}
    one.command(name)(call)
    return get_command(one)


def refuse(given: Mapping[str, Any], why: str) -> None:
    """Refuse the first option that was given; those not given are empty, False or None."""
    for name, value in given.items():
        missing = value is None or value is False or value == []  # zero was given
        require(missing, name, value, f"left out {why}")


def refuse_with_redraw(redraw: bool, options: Mapping[str, Any]) -> None:
    """Refuse options of a run if a stored result is only redrawn."""
    if redraw:
        refuse(options, "with --redraw, which runs nothing")


def refuse_another(given: Mapping[str, Any], stored: Mapping[str, Any]) -> None:
    """Refuse to redraw a stored result whose inputs differ from the given options."""
    for name, value in given.items():
        allowed = f"{stored.get(name)!r}, as the stored result has it"
        require(value == stored.get(name), name, value, allowed)


def load(
    scene: str, overrides: Sequence[str] | None, backend: Backend | None, data: str | None
) -> "Scene | MatrixScene":
    """Load a scene of bodies or of matrices; refuse options of the other kind."""
    from scenes.spec.plain import is_of_matrices

    if is_of_matrices(scene):
        from scenes.spec.matrices import load_matrices

        refuse({"backend": backend}, "of a scene of matrices, which has no bodies")
        return load_matrices(scene, overrides or (), data)
    from scenes.spec.reading import load_scene

    refuse({"data": data}, "of a scene of bodies, which reads no matrices")
    return load_scene(scene, overrides or (), backend)


def with_backend(scene: str, overrides: Sequence[str], backend: Backend | None) -> tuple[str, ...]:
    """Overrides, followed by those that set the backend of every body of a scene."""
    chosen = None if backend is None else load(scene, overrides, backend, None)
    bodies = getattr(chosen, "bodies", ())
    return (*overrides, *(f'bodies.{name}.backend="{backend}"' for name in bodies))


def deliver(write: Callable[[Path], Path], out: Path) -> Path:
    """Write a new folder that replaces an earlier result; return the file to open."""
    from cea.petsc import MPI
    from scenes.results.folder import new_folder

    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        return new.final(write(new.part))
