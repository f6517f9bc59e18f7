"""Commands of scenes: check, list, export, reference, schema."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from typer import Option

from comparisons.cli.options import Data, OnBackend, Out, SceneName, Settings, group, load, need

if TYPE_CHECKING:
    from scenes.spec.reading import Scene

app = group("Check, list and export scenes without running them; describe their fields.")

_File = Annotated[Path | None, Option(help="File to write instead of printing.")]


@app.command()
def check(
    scene: SceneName,
    set_: Settings = None,
    backend: OnBackend = None,
    data: Data = None,
    picture: Annotated[bool, Option("--picture/--no-picture", help="Draw the scene.")] = True,
    out: Out = Path("results/check"),
) -> None:
    """Report every fault of a scene, or what a run of it needs, without solving."""
    from scenes.spec.reading import Scene

    chosen = load(scene, set_, backend, data)
    if isinstance(chosen, Scene):
        _check_bodies(chosen, out / f"{Path(scene).stem}.png" if picture else None)
    else:
        from scenes.matrices.reading import matrix_pencil, read_pieces

        pieces = read_pieces(chosen)
        matrix_pencil(chosen, pieces)
        typer.echo(f"matrices: {', '.join(pieces)}")
    typer.echo("no faults")


def _check_bodies(scene: "Scene", file: Path | None) -> None:
    """Inspect a scene of bodies; faults end the command, one line each."""
    from cea.files import check_writable
    from comparisons.cli.output import print_skipped, print_warnings, working
    from scenes.checking.check import inspect_scene, told

    if file is not None:
        need("pictures")
        check_writable(file, "out")
    with working("bodies and contact points"):
        inspection = inspect_scene(scene)
    for line in told(inspection):
        typer.echo(line)
    print_warnings(warning.plain() for warning in inspection.warnings)
    print_skipped(inspection.skipped)
    if file is not None and inspection.bodies:
        from scenes.results.pictures import draw_scene

        typer.echo(f"The picture to open: {draw_scene(inspection, file)}")
    inspection.faults.refuse()


@app.command(name="list")
def list_() -> None:
    """List the scenes that come with the project."""
    from comparisons.cli.output import console, print_columns
    from scenes.checking.memory import dofs_of
    from scenes.spec.plain import OF_MATRICES, scene_names, tables_of
    from scenes.spec.reading import load_scene

    rows = []
    for name in scene_names():
        chosen = load_scene(name)
        dofs = sum(map(dofs_of, chosen.bodies.values()))
        rows.append((name, f"{dofs:.0f}", ", ".join(chosen.bodies), _first(chosen.description)))
    for name in scene_names(OF_MATRICES):
        rows.append((name, "", "matrices", _first(tables_of(name).get("description", ""))))
    heads = ("scene", "dofs, about", "bodies", "what it is")
    texts = zip(heads, zip(*rows, strict=True), strict=True)
    print_columns(console, [(head, list(cells), head == heads[1]) for head, cells in texts])


def _first(description: str) -> str:
    """First sentence of a description, on one line."""
    return " ".join(description.split()).partition(". ")[0].rstrip(".")


@app.command()
def export(
    scene: SceneName,
    to: Annotated[Literal["inp"], Option(help="Format: decks of CalculiX.")] = "inp",
    set_: Settings = None,
    backend: Annotated[Literal["fe"] | None, Option(help="Backend for every body.")] = None,
    modes: Annotated[int, Option(help="Number of modes that the decks request.")] = 20,
    out: Out = Path("results/export"),
) -> None:
    """Write a scene of Lagrange elements as an input deck of CalculiX."""
    from comparisons.cli.output import working
    from scenes.export.calculix import write_deck
    from scenes.spec.reading import load_scene

    with working("export"):
        files = write_deck(load_scene(scene, set_ or [], backend), out, modes)
    for file in files:
        typer.echo(f"{file}")


@app.command()
def reference(out: _File = None) -> None:
    """Print every field of a scene, its type, default and meaning, as Markdown."""
    from scenes.spec.schema import reference_text

    _deliver(reference_text(), out)


@app.command()
def schema(
    matrices: Annotated[bool, Option("--matrices", help="Schema of scenes of matrices.")] = False,
    out: _File = None,
) -> None:
    """Print the JSON Schema of scenes, with which editors complete and check them."""
    from scenes.spec.schema import schema_text

    _deliver(schema_text("matrices" if matrices else "bodies"), out)


def _deliver(text: str, out: Path | None) -> None:
    if out is None:
        typer.echo(text, nl=False)
        return
    from cea.files import check_writable, write_whole

    check_writable(out, "out")
    write_whole(text.encode(), out)
    typer.echo(str(out))
