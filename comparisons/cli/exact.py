"""The command line ``cea exact``: reference eigenvalues for any parameters."""

import inspect
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import typer

from cea.errors import InputError
from comparisons.cli.options import PLAIN, LazyGroup, command_with, need

if TYPE_CHECKING:
    from exact_cea.entries import Entry
    from exact_cea.material import Material

_HELP = {
    "m": "Circumferential order; may be repeated.",
    "p": "Contact stiffness per area, or inf.",
    "mu": "Friction coefficient; of blocks constant, in the place of mu0.",
    "mu0": "Friction mu0 sin(pi x / length) [0.3].",
    "thresholds": "Instead: exceptional points up to mu0.",
    "kz": "Wave number in z, e.g. pi/2; none: plane strain.",
    "E": "Young's modulus",
    "nu": "Poisson's ratio",
    "rho": "Density",
    "height": "Thickness",
    "inner": "Inner radius.",
    "interface": "Radius of the interface.",
    "outer": "Outer radius.",
    "length": "Distance of the roller walls.",
    "k11": "Stiffness.",
    "k12": "Coupling.",
    "k22": "Stiffness.",
    "k3": "That of the contact.",
    "k1": "Stiffness of contact 1.",
    "k2": "Stiffness of contact 2.",
    "c1": "Damping of contact 1.",
    "c2": "Damping of contact 2.",
    "rotation": "Speed of the frame.",
    "max_frequency": "List all eigenvalues with Im up to this, Re to half.",
    "count": "Or: list so many, lowest first.",
    "json": "File for the entries.",
}
"""Help of options; of those that end in _a and _b it is that of the name before, of each body."""
_TYPES: Mapping[str, Any] = {
    "m": list[int],
    "thresholds": bool,
    "count": int | None,
    "json": Path | None,
    "max_frequency": float | None,
}
"""Types of options that are no text; numbers are texts, which keep all their digits."""

_ELASTIC = {"E_a": "0.1", "nu_a": "0.25", "rho_a": "0.35", "E_b": "1", "nu_b": "0.3", "rho_b": "1"}
_BRAKE = {
    "E_a": "1e10",
    "nu_a": "0.25",
    "rho_a": "2500",
    "E_b": "2.1e11",
    "nu_b": "0.3",
    "rho_b": "7800",
}
_LIST = {"max_frequency": None, "count": None, "json": None}


def _drum(o: Any) -> "list[Entry]":
    """Annulus a around annulus b, clamped outside and inside, in plane strain or 3D (--kz)."""
    from exact_cea import entries
    from exact_cea.drum import Drum

    radii = o.inner, o.interface, o.outer
    problems = [Drum.of(m, o.p, o.mu, o.kz, *_materials(o), *radii) for m in o.m]
    return [entries.drum(problem, *_window(o, 14)) for problem in problems]


def _blocks(o: Any) -> "list[Entry]":
    """Layer a on layer b between roller walls, with sinusoidal or constant friction."""
    from exact_cea import entries
    from exact_cea.blocks import Blocks

    if o.mu is not None and (o.mu0 is not None or o.thresholds):
        raise InputError("mu", o.mu, "not together with mu0 or thresholds")
    default = "1" if o.thresholds else "0.3"
    friction = next(each for each in (o.mu, o.mu0, default) if each is not None)
    problem = Blocks.of(o.p, friction, o.kz, *_materials(o), o.height_a, o.height_b, o.length)
    if o.thresholds:
        if o.max_frequency is None or o.count is not None:
            allowed = "given, without count, for thresholds"
            raise InputError("max_frequency", o.max_frequency, allowed)
        return entries.thresholds(problem, float(problem.mu0), o.max_frequency)
    make = entries.blocks_sine if o.mu is None else entries.blocks_constant
    return [make(problem, *_window(o, 11))]


def _ring(o: Any) -> "list[Entry]":
    """Ring pad a on disc b with rolling rims, by a Galerkin method of high degree."""
    from exact_cea import entries
    from exact_cea.galerkin_problems import Ring

    sizes = o.inner, o.outer, o.height_a, o.height_b
    problems = [Ring.of(m, o.p, o.mu, *_materials(o), *sizes) for m in o.m]
    return [entries.ring(problem, *_window(o, 20)) for problem in problems]


def _hoffmann(o: Any) -> "list[Entry]":
    """A system of two degrees of freedom, the model of Hoffmann."""
    from exact_cea import entries, lumped

    stiffness = o.k11, o.k12, o.k22, o.k3
    info = {"mu_c": str(float(lumped.hoffmann_threshold(*stiffness)))}
    return [entries.lumped_system(lumped.hoffmann(o.mu, *stiffness), info)]


def _hulten(o: Any) -> "list[Entry]":
    """A system of two degrees of freedom, the model of Hulten."""
    from exact_cea import entries, lumped

    contacts, info = (o.k1, o.k2, o.c1, o.c2), {}
    if not lumped.rationals(rotation=o.rotation)[0]:
        found = zip(("mu_c", "omega_c2"), lumped.hulten_threshold(*contacts), strict=True)
        info = {name: value.str(22, radius=False) for name, value in found}
    return [entries.lumped_system(lumped.hulten(o.mu, *contacts, o.rotation), info)]


_DEFAULTS: dict[str, dict[str, Any]] = {
    "drum": {"m": ..., "p": "1", "mu": "0.3", "kz": None}
    | _ELASTIC
    | {"inner": "0.5", "interface": "1", "outer": "1.5"}
    | _LIST,
    "blocks": {"p": "1", "mu0": None, "mu": None, "thresholds": False, "kz": None}
    | _ELASTIC
    | {"height_a": "0.5", "height_b": "1", "length": "2"}
    | _LIST,
    "ring": {"m": ..., "p": "1e12", "mu": "0.3"}
    | _BRAKE
    | {"inner": "0.08", "outer": "0.16", "height_a": "0.01", "height_b": "0.02"}
    | _LIST,
    "hoffmann": {"mu": "0.3", "k11": "2.5", "k12": "0.5", "k22": "2", "k3": "4/3", "json": None},
    "hulten": {"mu": "0.3", "k1": "1", "k2": "1.44", "c1": "0", "c2": "0", "rotation": "0"}
    | {"json": None},
}
"""Options of each problem with their defaults."""
_PROBLEMS = {
    made.__name__[1:]: (made, inspect.getdoc(made) or "")
    for made in (_drum, _blocks, _ring, _hoffmann, _hulten)
}
"""What makes the entries of each problem, and its help."""


class _Problems(LazyGroup):
    """A command for each problem."""

    table = _PROBLEMS

    def make(self, name: str) -> Any:
        """Command of a problem."""
        make, _ = self.table[name]

        def call(**given: Any) -> None:
            from cea.files import check_writable

            if given["json"] is not None:
                check_writable(given["json"], "json")
            _deliver(make(SimpleNamespace(**given)), given["json"])

        call.__doc__ = make.__doc__
        options = {}
        for option, default in _DEFAULTS[name].items():
            quantity, _, body = option.rpartition("_")
            text = f"{_HELP[quantity]} of body {body}." if body in ("a", "b") else _HELP[option]
            kind = str | None if default is None else str
            options[option] = (_TYPES.get(option, kind), default, text)
        return command_with(call, options, name)


app = typer.Typer(cls=_Problems, no_args_is_help=True, **PLAIN)


@app.callback()
def exact() -> None:
    """Exact eigenvalues of frictional contacts, without finite elements or splines."""
    need("exact")


def _materials(o: Any) -> "tuple[Material, Material]":
    from exact_cea.material import Material

    a, b = (o.E_a, o.nu_a, o.rho_a), (o.E_b, o.nu_b, o.rho_b)
    return Material.of(*a, "a"), Material.of(*b, "b")


def _window(o: Any, default: int) -> tuple[float | None, int | None]:
    count = default if o.max_frequency is None and o.count is None else o.count
    return o.max_frequency, count


_NOT_IN_LINE = (
    "lam",
    "lam_contact_free",
    "digits_each",
    "M",
    "C",
    "K",
    "window",
    "a",
    "b",
    "sizes",
)
"""What an entry holds beside what its first line shows."""


def _deliver(found: "list[Entry]", file: Path | None) -> None:
    from exact_cea import entries

    for entry in found:
        typer.echo("  ".join(f"{key}={entry[key]}" for key in entry if key not in _NOT_IN_LINE))
        for real, imaginary in entry.get("lam", []):
            typer.echo(f"{real:>32} {imaginary:>28}")
        for _, imaginary in entry.get("lam_contact_free", []):
            typer.echo(f"{'contact free':>32} {imaginary:>28}")
    if file is not None:
        entries.write(found, file)
        typer.echo(str(file))
