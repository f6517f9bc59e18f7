"""The command ``cea bench calculix``: CalculiX beside this program."""

from pathlib import Path
from typing import Annotated

import typer


def peers(
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Run both anew (minutes); needs CalculiX.")
    ] = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="With --recompute, one coarse mesh: half a minute.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("results/peers"),
) -> None:
    """Show what CalculiX and this program find on the same meshes, and how long they take."""
    from cea.files import check_writable
    from comparisons.cli.output import console, print_table
    from comparisons.kit.progress import Progress
    from comparisons.peers.page import read_peers, write_peers
    from comparisons.peers.study import QUICK, STORED, PeersStudy, run_peers
    from comparisons.peers.tables import differences_table, times_table, unstable_table
    from comparisons.peers.words import summary

    check_writable(out / "result.json", "out")
    if recompute:
        with console.status("peers") as status:
            progress = Progress(step=lambda name: console.print(f"· {name}"), stage=status.update)
            data = run_peers(QUICK if quick else PeersStudy(), progress)
    else:
        data = read_peers(STORED)
    page = write_peers(data, out)
    for make in (differences_table, unstable_table, times_table):
        print_table(make(data))
    typer.echo(summary(data))
    typer.echo(f"The page to open: {page}")
