"""The commands ``cea sweep`` and ``cea threshold``: one scene along its fields."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from comparisons.sweep.axes import Axis


IN_PART = 3
"""Exit code of a command that answered in part."""
_CONFIRM = 3
"""Thresholds of a map that are confirmed where no number is given."""


def sweep(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    axes: Annotated[
        list[str],
        typer.Argument(
            help="What varies: field=first:last:count, or ...:last:log:count; or how it is spread: "
            "field~normal:mean:deviation, ~lognormal:median:deviation, ~uniform:low:high."
        ),
    ],
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override of another field.")
    ] = None,
    backend: Annotated[
        Literal["fe", "iga"] | None, typer.Option(help="Backend for every body.")
    ] = None,
    data: Annotated[
        str | None, typer.Option(help="Folder of the files that a scene of matrices names.")
    ] = None,
    samples: Annotated[
        int | None, typer.Option(help="Samples of fields that are spread; 10,000 by default.")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the samples; 0 by default.")] = None,
    full: Annotated[
        bool | None,
        typer.Option(
            "--full/--basis",
            help="Solve each value of one field in full, or use a basis at any price. By default "
            "what is cheaper along one field, and a basis else.",
        ),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(help="Error of lambda, relative, up to which a value is certified.")
    ] = 1e-8,
    solves: Annotated[int, typer.Option(help="Most full solves of a map.")] = 150,
    checks: Annotated[int, typer.Option(help="Full solves at random values that test a map.")] = 2,
    confirm: Annotated[
        int, typer.Option(help="Thresholds of a map that full solves confirm.")
    ] = _CONFIRM,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Draw the result in --out anew, run nothing.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/sweep"),
) -> None:
    """Follow the modes of a scene along its fields: what grows where, and from where on.

    Parameters of a scene (mu and P of contacts, E, rho, damping and rotation of bodies) are swept
    by a basis of a few full solves with a bound for every value, one other field by a full solve
    at each value. Of fields that are spread samples tell how probable it is that each mode grows.
    """
    from cea.errors import InputError
    from comparisons.cli.backend import with_backend
    from comparisons.cli.extras import need
    from comparisons.cli.redraw import refuse_with_redraw
    from comparisons.cli.samples import are_distributions, sample
    from comparisons.sweep.axes import read_axis
    from scenes.results.folder import check_out

    need("pictures")
    refuse_with_redraw(redraw, {"set": set_, "backend": backend, "data": data})
    overrides = with_backend(scene, set_ or (), backend)
    if are_distributions(axes):
        _refuse_beside_samples(full=bool(full), confirm=confirm)
        need_maps()
        options = {
            "count": samples,
            "seed": seed,
            "overrides": overrides,
            "data": data,
            "tolerance": tolerance,
            "most": solves,
            "checks": checks,
        }
        sample(scene, axes, options, out, redraw=redraw)
        return
    for name, value in (("samples", samples), ("seed", seed)):
        if value is not None:
            raise InputError(name, value, "left out but for distributions: mu~normal:0.4:0.05")
    asked = [read_axis(axis) for axis in axes]
    if redraw:
        _draw_anew(scene, asked, out)
        return
    check_out(out)
    if full:
        _each_in_full(scene, asked, overrides, data, "--full", out)
        return
    need_maps()
    from comparisons.sweep.map_study import AskedMap
    from comparisons.sweep.mapped import NoMapError
    from comparisons.sweep.thrift import BasisTooDearError

    open_ = full is None and len(asked) == 1 and not asked[0].logarithmic and confirm == _CONFIRM
    map_ = AskedMap(
        scene, tuple(asked), overrides, data, tolerance, solves, checks, confirm, thrifty=open_
    )
    try:
        _map(map_, out)
    except (NoMapError, BasisTooDearError) as error:
        if len(asked) > 1:
            raise
        _each_in_full(scene, asked, overrides, data, str(error), out)


def _refuse_beside_samples(*, full: bool, confirm: int) -> None:
    """Refuse options that samples have no use for."""
    from cea.errors import InputError

    if full:
        raise InputError("full", True, "left out for samples: they are solved on a basis")
    if confirm != _CONFIRM:
        raise InputError("confirm", confirm, "left out for samples: they have no thresholds")


def _map(asked: Any, out: Path) -> None:
    """Make a map and tell of it."""
    from cea.petsc import MPI
    from comparisons.cli.output import print_table, print_warnings
    from comparisons.cli.progress import working
    from comparisons.sweep.map_page import write_result
    from comparisons.sweep.map_study import run_map
    from comparisons.sweep.map_tables import headline, summary_table, thresholds_table
    from scenes.results.folder import new_folder

    with working("map") as work:
        found, rows, store = run_map(asked, out, work.stage)
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        page = new.final(write_result(found, rows, new.part))
    store.discard()
    typer.echo(headline(found))
    typer.echo(found["words"])
    print_table(summary_table(found))
    print_table(thresholds_table(found))
    print_warnings(found["warnings"])
    typer.echo(f"Every value: {out / 'sweep.nc'}")
    typer.echo(f"The page to open: {page}")
    if found["unresolved"]:
        raise typer.Exit(IN_PART)


def _each_in_full(
    scene: str,
    axes: "list[Axis]",
    overrides: tuple[str, ...],
    data: str | None,
    why: str,
    out: Path,
) -> None:
    """Solve at each value of one field, and tell of it."""
    from cea.errors import InputError
    from cea.petsc import MPI
    from comparisons.cli.output import print_table, print_warnings
    from comparisons.cli.progress import working
    from comparisons.sweep.page import write_sweep
    from comparisons.sweep.study import Sweep, run_sweep
    from comparisons.sweep.tables import unstable_table, values_table
    from scenes.results.folder import new_folder

    if len(axes) > 1:
        raise InputError("axis", axes[1].name, "one field only with --full")
    axis = axes[0]
    if axis.logarithmic:
        raise InputError("axis", axis.name, "evenly spaced where each value is solved in full")
    asked = Sweep(scene, axis.name, axis.first, axis.last, axis.count, overrides, data)
    with working("sweep", steps=axis.count) as work:
        found = run_sweep(asked, work.step, why)
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        picture = new.final(write_sweep(found, new.part))
    print_table(values_table(found))
    print_table(unstable_table(found))
    print_warnings(found["warnings"])
    typer.echo(f"Solved in full at each value: {why}")
    typer.echo(f"The picture to open: {picture}")


def _draw_anew(scene: str, axes: "list[Axis]", out: Path) -> None:
    """Draw a sweep from its record."""
    from cea.petsc import MPI
    from comparisons.cli.redraw import refuse_another
    from comparisons.sweep.map_page import write_result
    from comparisons.sweep.netcdf import read_map
    from comparisons.sweep.page import read_sweep, write_sweep
    from scenes.results.folder import new_folder

    found, rows = read_sweep(out), None
    asked: dict[str, Any] = {"scene": scene, "axes": [dict(axis.plain()) for axis in axes]}
    if "axes" in found:
        need_maps()
        rows = read_map(found, out / "sweep.nc")
    else:
        axis = axes[0]
        asked = {"scene": scene, "field": axis.name, "start": axis.first, "stop": axis.last}
    refuse_another(asked, found["inputs"])
    with new_folder(out, root=MPI.COMM_WORLD.rank == 0) as new:
        written = write_sweep(found, new.part) if rows is None else None
        made = new.final(written or write_result(found, rows or [], new.part))
    typer.echo(f"The {'picture' if rows is None else 'page'} to open: {made}")


def threshold(
    scene: Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")],
    axes: Annotated[
        list[str],
        typer.Argument(help="What varies, the field of the thresholds first, as in cea sweep."),
    ],
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Override of another field.")
    ] = None,
    backend: Annotated[
        Literal["fe", "iga"] | None, typer.Option(help="Backend for every body.")
    ] = None,
    data: Annotated[
        str | None, typer.Option(help="Folder of the files that a scene of matrices names.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/threshold"),
) -> None:
    """Find where modes begin and cease to grow along a field, each confirmed by a full solve.

    Every change of the number of growing modes is explained by a threshold, or its interval is
    reported as unresolved: the exit code is 3 then.
    """
    from comparisons.cli.backend import with_backend
    from comparisons.sweep.axes import read_axis
    from scenes.results.folder import check_out

    need_maps()
    asked = tuple(read_axis(axis) for axis in axes)
    check_out(out)
    from comparisons.sweep.map_study import AskedMap

    overrides = with_backend(scene, set_ or (), backend)
    _map(AskedMap(scene, asked, overrides, data, confirm=_EVERY), out)


_EVERY = 10_000
"""More thresholds than a map has."""


def need_maps() -> None:
    """Refuse to begin without what maps need."""
    from comparisons.cli.extras import need

    need("pictures", "maps")
