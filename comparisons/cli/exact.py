"""The command line ``cea exact``: reference eigenvalues for any parameters.

Options are the parameters of the problems of :mod:`exact_cea`, read as text to keep all digits.
"""

import inspect
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

import typer

from cea.errors import InputError
from comparisons.cli.options import LazyGroup, command_with, group, need

if TYPE_CHECKING:
    from exact_cea.entries import Entry

Options = Mapping[str, tuple[Any, Any, str]]
"""Type, default and help of options by name."""
_LIST: Options = {
    "max_frequency": (float | None, None, "List all with Im up to this, Re up to half of it."),
    "count": (int | None, None, "Or: list this many, lowest first."),
}
_FRICTION: Options = {
    "mu0": (str | None, None, "Friction mu0 sin(pi x / length) [0.3]."),
    "mu": (str | None, None, "Constant friction coefficient instead of mu0."),
    "thresholds": (bool, False, "List exceptional points up to mu0 instead."),
}
_MU: Options = {"mu": (str, "0.3", "Friction coefficient.")}
_JSON: Options = {"json": (Path | None, None, "File for the entries.")}


def _drum(entries: Any, problem: Any, given: dict[str, Any], o: Any) -> "list[Entry]":
    """Annulus a around annulus b, clamped outside and inside, in plane strain or 3D (--kz)."""
    return [entries.drum(problem.of(m, **given), *_window(o, 14)) for m in o.m]


def _blocks(entries: Any, problem: Any, given: dict[str, Any], o: Any) -> "list[Entry]":
    """Layer a on layer b between roller walls, with sinusoidal or constant friction."""
    if o.mu is not None and (o.mu0 is not None or o.thresholds):
        raise InputError("mu", o.mu, "not together with mu0 or thresholds")
    default = "1" if o.thresholds else "0.3"
    friction = next(each for each in (o.mu, o.mu0, default) if each is not None)
    blocks = problem.of(**given | {"mu0": friction})
    if o.thresholds:
        if o.max_frequency is None or o.count is not None:
            allowed = "given, without count, for thresholds"
            raise InputError("max_frequency", o.max_frequency, allowed)
        return entries.thresholds(blocks, float(blocks.mu0), o.max_frequency)
    make = entries.blocks_sine if o.mu is None else entries.blocks_constant
    return [make(blocks, *_window(o, 11))]


def _ring(entries: Any, problem: Any, given: dict[str, Any], o: Any) -> "list[Entry]":
    """Ring pad a on disc b with rolling rims, by a Galerkin method of high degree."""
    return [entries.ring(problem.of(m, **given), *_window(o, 20)) for m in o.m]


def _hoffmann(entries: Any, problem: Any, given: dict[str, Any], o: Any) -> "list[Entry]":
    """A system of two degrees of freedom, the model of Hoffmann."""
    from exact_cea import lumped

    threshold = lumped.hoffmann_threshold(o.k11, o.k12, o.k22, o.k3)
    return [entries.lumped_system(problem(**given), {"mu_c": str(float(threshold))})]


def _hulten(entries: Any, problem: Any, given: dict[str, Any], o: Any) -> "list[Entry]":
    """A system of two degrees of freedom, the model of Hulten."""
    from exact_cea import lumped

    info = {}
    if not lumped.rationals(rotation=o.rotation)[0]:
        mu, square = lumped.hulten_threshold(o.k1, o.k2, o.c1, o.c2)
        info = {"mu_c": mu.str(22, radius=False), "omega_c2": square.str(22, radius=False)}
    return [entries.lumped_system(problem(**given), info)]


_PROBLEMS = {
    made.__name__[1:]: ((made, place, options), inspect.getdoc(made) or "")
    for made, place, options in (
        (_drum, "drum:Drum", _LIST),
        (_blocks, "blocks:Blocks", {**_FRICTION, **_LIST}),
        (_ring, "galerkin_problems:Ring", _LIST),
        (_hoffmann, "lumped:hoffmann", _MU),
        (_hulten, "lumped:hulten", _MU),
    )
}
"""Function that makes entries of each problem, its place below exact_cea, options; help text."""


class _Problems(LazyGroup):
    """A command for each problem."""

    table = _PROBLEMS

    def make(self, name: str) -> Any:
        """The command of a problem."""
        need("exact")
        (make, place, more), _ = self.table[name]
        module, _, attribute = place.partition(":")
        problem = getattr(import_module(f"exact_cea.{module}"), attribute)

        def call(**given: Any) -> None:
            from cea.files import check_writable
            from exact_cea import entries

            if given["json"] is not None:
                check_writable(given["json"], "json")
            chosen = _parameters(problem, given)
            _deliver(make(entries, problem, chosen, SimpleNamespace(**given)), given["json"])

        call.__doc__ = make.__doc__
        return command_with(call, {**_own_options(problem), **more, **_JSON}, name)


def _own_options(problem: Any) -> dict[str, tuple[Any, Any, str]]:
    """Options for the parameters of a problem that are annotated with a help text.

    A material gives one option for each of its numbers.
    """
    from exact_cea.material import Material

    found: dict[str, tuple[Any, Any, str]] = {}
    hints = get_type_hints(problem, include_extras=True)
    for name, parameter in inspect.signature(problem).parameters.items():
        hint, default = hints[name], parameter.default
        if hint is Material:
            for each, number in get_type_hints(Material, include_extras=True).items():
                text = f"{get_args(number)[1]} of body {name}."
                found[f"{each}_{name}"] = (str, str(getattr(default, each)), text)
        elif name == "m":
            found[name] = (list[int], ..., get_args(hint)[1])
        elif get_origin(hint) is Annotated:
            kind = str | None if default is None else str
            found[name] = (kind, default and str(default), get_args(hint)[1])
    return found


def _parameters(problem: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """Given parameters of a problem except the orders m, with its materials constructed."""
    from exact_cea.material import Material

    names = inspect.signature(problem).parameters.keys()
    chosen = {name: given[name] for name in names & given.keys() if name != "m"}
    for body in names & {"a", "b"}:
        E, nu, rho = (given[f"{each}_{body}"] for each in ("E", "nu", "rho"))
        chosen[body] = Material.of(E, nu, rho, body)
    return chosen


_TEXT = "Exact eigenvalues of frictional contacts, without finite elements or splines."
app = group(_TEXT, _Problems)


def _window(o: Any, default: int) -> tuple[float | None, int | None]:
    count = default if o.max_frequency is None and o.count is None else o.count
    return o.max_frequency, count


_LISTED = {"lam", "lam_contact_free", "digits_each", "M", "C", "K", "window", "a", "b", "sizes"}
"""Keys of an entry that its first line does not show."""


def _deliver(found: "list[Entry]", file: Path | None) -> None:
    from exact_cea import entries

    for entry in found:
        typer.echo("  ".join(f"{key}={entry[key]}" for key in entry if key not in _LISTED))
        for real, imaginary in entry.get("lam", []):
            typer.echo(f"{real:>32} {imaginary:>28}")
        for _, imaginary in entry.get("lam_contact_free", []):
            typer.echo(f"{'contact free':>32} {imaginary:>28}")
    if file is not None:
        entries.write(found, file)
        typer.echo(str(file))
