"""The command ``cea doctor``."""

import typer


def doctor() -> None:
    """Tell whether this installation works, and what mends it; code 1 where it does not."""
    from comparisons.cli.app import launched_together
    from comparisons.doctor import examine

    faults = 0
    for finding in examine(launched=launched_together() is not None):
        mark = "FAULT" if finding.mend else "well "
        typer.echo(f"{mark}  {finding.name}: {finding.told}")
        if finding.mend is not None:
            faults += 1
            typer.echo(f"       mend it: {finding.mend}")
    typer.echo("all is well" if not faults else f"faults: {faults}")
    if faults:
        raise typer.Exit(1)
