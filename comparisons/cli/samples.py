"""Samples as ``cea sweep`` takes them: fields that are spread, ``mu~normal:0.4:0.05``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import typer

_SAMPLES = 10_000
"""Samples where no number is given."""


def are_distributions(axes: Sequence[str]) -> bool:
    """Whether what varies are distributions.

    Raises
    ------
    InputError
        When some are and some are not.
    """
    from cea.errors import InputError

    spread = ["~" in axis and "=" not in axis.partition("~")[0] for axis in axes]
    if any(spread) and not all(spread):
        other = axes[spread.index(False)]
        raise InputError("axis", other, "a distribution, as the others are: name~normal:0.4:0.05")
    return any(spread)


def sample(
    scene: str, texts: Sequence[str], options: dict[str, Any], out: Path, *, redraw: bool
) -> None:
    """Solve samples of a scene and tell of them.

    Parameters
    ----------
    scene
        TOML file, or the name of a scene.
    texts
        The distributions.
    options
        Of :class:`comparisons.sweep.sample_study.AskedSamples`; ``count`` and ``seed`` may be None.
    out
        Folder of the result.
    redraw
        Whether the result there is drawn anew.
    """
    from comparisons.sweep.distributions import read_distribution
    from comparisons.sweep.sample_study import AskedSamples

    distributions = tuple(map(read_distribution, texts))
    options = options | {"count": options["count"] or _SAMPLES, "seed": options["seed"] or 0}
    asked = AskedSamples(scene, distributions, **options)
    if redraw:
        _draw_anew(asked, out)
    else:
        _run(asked, out)


def _run(asked: Any, out: Path) -> None:
    from cea.petsc import MPI
    from comparisons.cli.output import print_table, print_warnings
    from comparisons.cli.progress import working
    from comparisons.sweep.sample_page import FILE, write_samples
    from comparisons.sweep.sample_study import run_samples
    from comparisons.sweep.sample_tables import probability_table, samples_summary
    from scenes.results.folder import check_out, new_folder

    check_out(out)
    with working("samples") as work:
        data, drawn, found, store = run_samples(asked, out, work.stage)
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        page = new.final(write_samples(data, drawn, found, new.part))
    store.discard()
    print_table(samples_summary(data))
    print_table(probability_table(data))
    print_warnings(data["warnings"])
    typer.echo(f"Every sample: {out / FILE}")
    typer.echo(f"The page to open: {page}")


def _draw_anew(asked: Any, out: Path) -> None:
    from cea.petsc import MPI
    from comparisons.cli.redraw import refuse_another
    from comparisons.sweep.page import read_sweep
    from comparisons.sweep.sample_page import FILE, read_samples, write_samples
    from scenes.results.folder import new_folder

    data = read_sweep(out)
    wanted = asked.plain()
    refuse_another({key: wanted[key] for key in ("scene", "distributions")}, data["inputs"])
    drawn, found = read_samples(data, out / FILE)
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        page = new.final(write_samples(data, drawn, found, new.part))
    typer.echo(f"The page to open: {page}")
