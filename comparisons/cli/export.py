"""The command ``cea scene export``: a scene for other programs."""

from pathlib import Path
from typing import Annotated, Literal

import typer


def export(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    to: Annotated[
        Literal["inp"], typer.Option(help="Form: inp, decks of CalculiX and Abaqus.")
    ] = "inp",
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override, e.g. contacts.pad_disc.mu=0.3")
    ] = None,
    backend: Annotated[
        Literal["fe"] | None, typer.Option(help="Backend for every body; decks need fe.")
    ] = None,
    modes: Annotated[int, typer.Option(help="Modes that the decks ask for.")] = 20,
    out: Annotated[Path, typer.Option(help="Folder of the decks.")] = Path("results/export"),
) -> None:
    """Write a scene of Lagrange elements as input decks of CalculiX and Abaqus."""
    from cea.petsc import MPI
    from comparisons.cli.output import console
    from scenes.export.decks.write import write_deck
    from scenes.spec.reading import load_scene

    with console.status("export"):
        files = write_deck(load_scene(scene, set_ or [], backend), out, modes)
    if MPI.COMM_WORLD.rank == 0:
        for file in files:
            typer.echo(f"{file}")
