"""The commands ``cea sweep`` and ``cea threshold``: one scene along its fields."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from comparisons.cli.options import (
    Backend,
    deliver,
    need,
    refuse,
    refuse_another,
    refuse_with_redraw,
    with_backend,
)

if TYPE_CHECKING:
    from comparisons.sweep.axes import Axis

IN_PART = 3
"""Exit code of a command that answered in part."""
_CONFIRM = 3
"""Thresholds of a map that are confirmed where no number is given."""
_EVERY = 10_000
"""More thresholds than a map has, and samples where no number is given."""

_Scene = Annotated[str, typer.Argument(help="TOML file, or the name of a scene.")]
_Set = Annotated[list[str] | None, typer.Option("--set", help="Override of another field.")]
_Backend = Annotated[Backend | None, typer.Option(help="Backend for every body.")]
_Data = Annotated[
    str | None, typer.Option(help="Folder of the files that a scene of matrices names.")
]


def sweep(
    scene: _Scene,
    axes: Annotated[
        list[str],
        typer.Argument(
            help="What varies: field=first:last:count, or ...:last:log:count; or how it is spread: "
            "field~normal:mean:deviation, ~lognormal:median:deviation, ~uniform:low:high."
        ),
    ],
    set_: _Set = None,
    backend: _Backend = None,
    data: _Data = None,
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
    from comparisons.sweep.axes import read_axis
    from scenes.results.folder import check_out

    need("pictures")
    refuse_with_redraw(redraw, {"set": set_, "backend": backend, "data": data})
    overrides = with_backend(scene, set_ or (), backend)
    if are_distributions(axes):
        from comparisons.sweep.distributions import read_distribution
        from comparisons.sweep.sample_study import AskedSamples

        more = None if confirm == _CONFIRM else confirm
        refuse({"full": full, "confirm": more}, "for samples: they are solved on a basis")
        need("maps")
        asked = AskedSamples(
            scene,
            tuple(map(read_distribution, axes)),
            count=samples or _EVERY,
            seed=seed or 0,
            overrides=overrides,
            data=data,
            tolerance=tolerance,
            most=solves,
            checks=checks,
        )
        (_draw_samples_anew if redraw else _sample)(asked, out)
        return
    refuse({"samples": samples, "seed": seed}, "but for distributions: mu~normal:0.4:0.05")
    along = [read_axis(axis) for axis in axes]
    if redraw:
        _draw_anew(scene, along, out)
        return
    check_out(out)
    if full:
        _each_in_full(scene, along, overrides, data, "--full", out)
        return
    need("maps")
    from comparisons.sweep.map_study import AskedMap
    from comparisons.sweep.mapped import NoMapError
    from comparisons.sweep.thrift import BasisTooDearError

    open_ = full is None and len(along) == 1 and not along[0].logarithmic and confirm == _CONFIRM
    try:
        _map(
            AskedMap(
                *(scene, tuple(along), overrides, data, tolerance, solves, checks, confirm),
                thrifty=open_,
            ),
            out,
        )
    except (NoMapError, BasisTooDearError) as error:
        if len(along) > 1:
            raise
        _each_in_full(scene, along, overrides, data, str(error), out)


def threshold(
    scene: _Scene,
    axes: Annotated[
        list[str],
        typer.Argument(help="What varies, the field of the thresholds first, as in cea sweep."),
    ],
    set_: _Set = None,
    backend: _Backend = None,
    data: _Data = None,
    out: Annotated[Path, typer.Option(help="Folder of the result.")] = Path("results/threshold"),
) -> None:
    """Find where modes begin and cease to grow along a field, each confirmed by a full solve.

    Every change of the number of growing modes is explained by a threshold, or its interval is
    reported as unresolved: the exit code is 3 then.
    """
    from comparisons.sweep.axes import read_axis
    from scenes.results.folder import check_out

    need("pictures", "maps")
    along = tuple(read_axis(axis) for axis in axes)
    check_out(out)
    from comparisons.sweep.map_study import AskedMap

    overrides = with_backend(scene, set_ or (), backend)
    _map(AskedMap(scene, along, overrides, data, confirm=_EVERY), out)


def are_distributions(axes: Sequence[str]) -> bool:
    """Whether what varies are distributions, ``mu~normal:0.4:0.05``.

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


def _map(asked: Any, out: Path) -> None:
    """Make a map and tell of it."""
    from comparisons.cli.output import print_table, print_warnings
    from comparisons.cli.progress import working
    from comparisons.sweep.map_page import write_result
    from comparisons.sweep.map_study import run_map
    from comparisons.sweep.map_tables import headline, summary_table, thresholds_table

    with working("map") as work:
        found, rows, store = run_map(asked, out, work.stage)
    page = deliver(lambda folder: write_result(found, rows, folder), out)
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
    from comparisons.cli.output import print_table, print_warnings
    from comparisons.cli.progress import working
    from comparisons.sweep.page import write_sweep
    from comparisons.sweep.study import Sweep, run_sweep
    from comparisons.sweep.tables import unstable_table, values_table

    if len(axes) > 1:
        raise InputError("axis", axes[1].name, "one field only with --full")
    axis = axes[0]
    if axis.logarithmic:
        raise InputError("axis", axis.name, "evenly spaced where each value is solved in full")
    asked = Sweep(scene, axis.name, axis.first, axis.last, axis.count, overrides, data)
    with working("sweep", steps=axis.count) as work:
        found = run_sweep(asked, work.step, why)
    picture = deliver(lambda folder: write_sweep(found, folder), out)
    print_table(values_table(found))
    print_table(unstable_table(found))
    print_warnings(found["warnings"])
    typer.echo(f"Solved in full at each value: {why}")
    typer.echo(f"The picture to open: {picture}")


def _sample(asked: Any, out: Path) -> None:
    """Solve samples of a scene and tell of them."""
    from comparisons.cli.output import print_table, print_warnings
    from comparisons.cli.progress import working
    from comparisons.sweep.sample_page import FILE, write_samples
    from comparisons.sweep.sample_study import run_samples
    from comparisons.sweep.sample_tables import probability_table, samples_summary
    from scenes.results.folder import check_out

    check_out(out)
    with working("samples") as work:
        data, drawn, found, store = run_samples(asked, out, work.stage)
    page = deliver(lambda folder: write_samples(data, drawn, found, folder), out)
    store.discard()
    print_table(samples_summary(data))
    print_table(probability_table(data))
    print_warnings(data["warnings"])
    typer.echo(f"Every sample: {out / FILE}")
    typer.echo(f"The page to open: {page}")


def _draw_samples_anew(asked: Any, out: Path) -> None:
    from comparisons.sweep.page import read_sweep
    from comparisons.sweep.sample_page import FILE, read_samples, write_samples

    data = read_sweep(out)
    wanted = asked.plain()
    refuse_another({key: wanted[key] for key in ("scene", "distributions")}, data["inputs"])
    drawn, found = read_samples(data, out / FILE)
    page = deliver(lambda folder: write_samples(data, drawn, found, folder), out)
    typer.echo(f"The page to open: {page}")


def _draw_anew(scene: str, axes: "list[Axis]", out: Path) -> None:
    """Draw a sweep from its record."""
    from comparisons.sweep.map_page import write_result
    from comparisons.sweep.page import read_sweep, write_sweep

    found = read_sweep(out)
    if "axes" in found:
        from comparisons.sweep.netcdf import read_map

        need("maps")
        refuse_another({"scene": scene, "axes": [dict(a.plain()) for a in axes]}, found["inputs"])
        rows = read_map(found, out / "sweep.nc")
        page = deliver(lambda folder: write_result(found, rows, folder), out)
        typer.echo(f"The page to open: {page}")
    else:
        axis = axes[0]
        asked = {"scene": scene, "field": axis.name, "start": axis.first, "stop": axis.last}
        refuse_another(asked, found["inputs"])
        picture = deliver(lambda folder: write_sweep(found, folder), out)
        typer.echo(f"The picture to open: {picture}")
