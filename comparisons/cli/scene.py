"""Commands of scenes: check, list, reference, schema."""

import sys
from pathlib import Path
from shutil import get_terminal_size
from typing import Annotated, Literal

import typer

from comparisons.cli.export import export

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.command("export")(export)

_Set = Annotated[
    list[str] | None, typer.Option("--set", help="Override, e.g. loads[0].pressure=1e5")
]


@app.callback()
def scene() -> None:
    """Look at scenes without running them; their fields, as text and for editors."""


@app.command()
def check(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    set_: _Set = None,
    backend: Annotated[
        Literal["fe", "iga"] | None, typer.Option(help="Backend for every body.")
    ] = None,
    data: Annotated[
        str | None, typer.Option(help="Folder of the files that a scene of matrices names.")
    ] = None,
    picture: Annotated[
        bool, typer.Option("--picture/--no-picture", help="Draw bodies, supports, contact points.")
    ] = True,
    out: Annotated[Path, typer.Option(help="Folder of the picture.")] = Path("results/check"),
) -> None:
    """Tell every fault of a scene, else what it would take; nothing is solved."""
    from scenes.spec.files import is_of_matrices

    if is_of_matrices(scene):
        _check_matrices(scene, set_ or [], data)
    else:
        _check_bodies(scene, set_ or [], backend, out if picture else None)


def _check_matrices(scene: str, set_: list[str], data: str | None) -> None:
    """Read a scene of matrices and the matrices it names."""
    from scenes.matrices.pencil import matrix_pencil, read_pieces
    from scenes.spec.matrices import load_matrices

    chosen = load_matrices(scene, set_, data)
    pieces = read_pieces(chosen)
    matrix_pencil(chosen, pieces)
    typer.echo(f"matrices: {', '.join(pieces)}")
    typer.echo("no faults")


def _check_bodies(
    scene: str, set_: list[str], backend: Literal["fe", "iga"] | None, out: Path | None
) -> None:
    """Look at a scene of bodies; faults end the command with their lines."""
    from cea.files import check_writable
    from comparisons.cli.extras import need
    from comparisons.cli.output import console, print_warnings
    from scenes.checking.check import inspect_scene, told
    from scenes.spec.problems import SceneError
    from scenes.spec.reading import load_scene

    if out is not None:
        need("pictures")
        check_writable(out / f"{Path(scene).stem}.png", "out")
    with console.status("reading the scene") as status:
        chosen = load_scene(scene, set_, backend)
        status.update("bodies and contact points")
        inspection = inspect_scene(chosen)
        if out is not None and inspection.bodies:
            from scenes.pictures.scene import draw_scene

            status.update("picture")
            file = draw_scene(inspection, out / f"{Path(scene).stem}.png")
    for line in told(inspection):
        typer.echo(line)
    print_warnings(warning.plain() for warning in inspection.warnings)
    if out is not None and inspection.bodies:
        typer.echo(f"The picture to open: {file}")
    if inspection.faults:
        raise SceneError(inspection.faults)
    typer.echo("no faults")


@app.command(name="list")
def list_() -> None:
    """List the scenes that come with the project."""
    from scenes.spec.consistency import dofs_of
    from scenes.spec.files import matrix_scene_names, scene_names, tables_of
    from scenes.spec.reading import load_scene

    rows = [("scene", "dofs, about", "bodies", "what it is")]
    for name in scene_names():
        chosen = load_scene(name)
        dofs = sum(map(dofs_of, chosen.bodies.values()))
        rows.append((name, f"{dofs:.0f}", ", ".join(chosen.bodies), _first(chosen.description)))
    for name in matrix_scene_names():
        rows.append((name, "", "matrices", _first(tables_of(name).get("description", ""))))
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    for name, dofs_told, bodies, what in rows:
        line = f"{name:{widths[0]}}  {dofs_told:>{widths[1]}}  {bodies:{widths[2]}}  {what}"
        typer.echo(_clipped(line))


def _clipped(line: str) -> str:
    """A line as long as the terminal is wide; whole where it goes elsewhere."""
    if not sys.stdout.isatty():
        return line
    width = get_terminal_size().columns
    return line if len(line) <= width else f"{line[: width - 3]}..."


def _first(description: str) -> str:
    """First sentence of a description, in one line."""
    words = " ".join(description.split())
    return words.partition(". ")[0].rstrip(".")


@app.command()
def reference(
    out: Annotated[Path | None, typer.Option(help="File to write instead.")] = None,
) -> None:
    """Every field of a scene, its type, default and meaning, as Markdown."""
    from scenes.spec.reference import reference_text

    _deliver(reference_text(), out)


@app.command()
def schema(
    matrices: Annotated[
        bool, typer.Option("--matrices", help="That of scenes of matrices.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="File to write instead.")] = None,
) -> None:
    """JSON Schema of scenes, with which editors complete and check them."""
    from scenes.spec.schema import schema_text

    _deliver(schema_text("matrices" if matrices else "bodies"), out)


def _deliver(text: str, out: Path | None) -> None:
    """Print a text, or write it to a file."""
    if out is None:
        typer.echo(text, nl=False)
        return
    from cea.files import check_writable, write_whole

    check_writable(out, "out")
    write_whole(text.encode(), out)
    typer.echo(str(out))
