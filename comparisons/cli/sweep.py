"""The commands ``cea sweep``, ``threshold`` and ``converge``."""

from pathlib import Path
from time import perf_counter
from typing import Annotated, Any, Literal

import typer
from typer import Argument, Option

from comparisons.cli import options

IN_PART = 3  # exit code for unresolved intervals, or digits that were not reached
_EVERY = 10_000  # confirms all thresholds: more than a sweep finds


def sweep(
    scene: options.SceneName,
    axes: Annotated[
        list[str],
        Argument(
            help="Axes field=first:last:count, or ...:last:log:count, or distributions "
            "field~normal:mean:deviation, ~lognormal:median:deviation, ~uniform:low:high."
        ),
    ],
    set_: options.Settings = None,
    backend: options.OnBackend = None,
    data: options.Data = None,
    samples: Annotated[int | None, Option(help="Number of samples; 2,000 by default.")] = None,
    seed: Annotated[int | None, Option(help="Seed of the samples; 0 by default.")] = None,
    full: Annotated[bool, Option("--full", help="Solve each value in full.")] = False,
    tolerance: Annotated[float, Option(help="Target of relative error bounds of lambda.")] = 1e-8,
    solves: Annotated[int, Option(help="Largest number of full solves.")] = 150,
    checks: Annotated[int, Option(help="Full solves at random values, to test bounds.")] = 2,
    confirm: Annotated[int | None, Option(help="Thresholds solved in full; 3 by default.")] = None,
    redraw: options.Redraw = False,
    out: options.Out = Path("results/sweep"),
) -> None:
    """Compute the modes of a scene over its fields: which modes grow where, and thresholds.

    Parameters of a scene (mu and P of contacts, E, rho, damping and rotation of bodies) are swept
    by a reduced model of a few full solves, with an error bound at every value; a single other
    field by a full solve at each value. Distributions are sampled, and the probability of growth
    of each mode is reported.
    """
    from comparisons.cli.output import print_frame, print_warnings, working
    from comparisons.sweep.page import FILE, answer_table, first_lines, read_sweep, write_sweep
    from comparisons.sweep.points import Axis, read_fields
    from comparisons.sweep.study import Asked, run
    from scenes.results.folder import check_out

    options.need("pictures", "maps")
    options.refuse_with_redraw(redraw, {"set": set_, "backend": backend, "data": data})
    overrides, fields = options.with_backend(scene, set_ or (), backend), read_fields(axes)
    of_samples: dict[str, Any] = {"samples": samples, "seed": seed}
    of_axes: dict[str, Any] = {"full": full or None, "confirm": confirm}
    if isinstance(fields[0], Axis):
        options.refuse(of_samples, "but for distributions: mu~normal:0.4:0.05")
    else:
        options.refuse(of_axes, "for samples, solved by a reduced model")
    given = {name: each for name, each in (of_samples | of_axes).items() if each is not None}
    limits: dict[str, Any] = {"tolerance": tolerance, "most": solves, "checks": checks}
    asked = Asked(scene, fields, overrides, data, **limits, **given)
    if redraw:
        made, told = read_sweep(out), asked.plain()
        same = {name: told[name] for name in ("scene", "fields")}
        options.refuse_another(same, made.record["inputs"])
    else:
        check_out(out)
        with working("sweep") as work:
            made = run(asked, out, work.stage)
    page = options.deliver(lambda folder: write_sweep(made, folder), out)
    if made.store is not None:
        made.store.discard()
    for line in first_lines(made):
        typer.echo(line)
    print_frame(answer_table(made), made)
    print_warnings(made.record["warnings"])
    typer.echo(f"Every value: {out / FILE}")
    typer.echo(f"The page to open: {page}")
    if made.record["unresolved"] and not redraw:
        raise typer.Exit(IN_PART)


def threshold(
    scene: options.SceneName,
    axes: Annotated[list[str], Argument(help="Axes as in cea sweep; thresholds along the first.")],
    set_: options.Settings = None,
    backend: options.OnBackend = None,
    data: options.Data = None,
    out: options.Out = Path("results/threshold"),
) -> None:
    """Find where modes begin and cease to grow along a field, each confirmed by full solves.

    Every change of the number of growing modes is explained by a threshold. Otherwise its interval
    is reported as unresolved, and the exit code is 3.
    """
    from comparisons.sweep.points import read_axis

    for axis in axes:
        read_axis(axis)  # refuses distributions
    sweep(scene, axes, set_, backend, data, confirm=_EVERY, out=out)


def converge(
    scene: options.SceneName,
    digits: Annotated[int, Option(help="Significant digits of frequencies.")] = 3,
    growth_digits: Annotated[
        int | None, Option(help="Digits of growth rates; one less by default.")
    ] = None,
    backend: Annotated[Literal["both", "fe", "iga"], Option(help="Backends to refine.")] = "both",
    budget: Annotated[float, Option(help="Limit of the run time (s).")] = 900.0,
    unstable: Annotated[
        bool, Option("--unstable", help="Ignore modes known to be stable.")
    ] = False,
    sweep_digits: Annotated[int, Option(help="Digits of the mesh proposed for sweeps.")] = 2,
    set_: options.Settings = None,
    redraw: options.Redraw = False,
    out: options.Out = Path("results/converge"),
) -> None:
    """Refine a scene until its modes reach the requested digits, and report their error bars."""
    begun = perf_counter()
    from comparisons.cli.output import print_frame, print_warnings, working
    from comparisons.converge.page import LEVELS, MODES, write_converge
    from comparisons.converge.request import Request
    from comparisons.converge.study import COMMAND, run_converge
    from comparisons.study.result import read_result
    from comparisons.study.session import Progress
    from scenes.results.folder import check_out

    options.need("pictures")
    options.refuse_with_redraw(redraw, {"set": set_, "unstable": unstable})
    backends = None if backend == "both" else (backend,)
    asked = scene, digits, growth_digits, backends, budget, unstable, sweep_digits
    request = Request(*asked, tuple(set_ or ()))
    if redraw:
        data = read_result(out, COMMAND)
        options.refuse_another({"scene": scene}, data["inputs"])
    else:
        check_out(out)
        with working("converge") as work:
            progress = Progress(step=work.step, stage=work.stage)
            data = run_converge(request, progress, begun)
    page = options.deliver(lambda folder: write_converge(data, folder), out)
    for line in (data["first"], data["words"], *data["hints"]):
        typer.echo(line)
    print_frame(MODES, data)
    print_frame(LEVELS, data)
    print_warnings(data["warnings"])
    typer.echo(f"The page to open: {page}")
    if not data["held"] and not redraw:
        raise typer.Exit(IN_PART)
