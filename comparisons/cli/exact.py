"""The command line ``cea exact``: reference eigenvalues for any parameters."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cea.errors import InputError
from cea.files import check_writable
from comparisons.cli.options import need

if TYPE_CHECKING:
    from exact_cea.entries import Entry
    from exact_cea.material import Material

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.callback()
def exact() -> None:
    """Exact eigenvalues of frictional contacts, without finite elements or splines."""
    need("exact")


_P = Annotated[str, typer.Option("--p", help="Contact stiffness per area, or inf.")]
_Mu = Annotated[str, typer.Option("--mu", help="Friction coefficient.")]
_M = Annotated[list[int], typer.Option("--m", help="Circumferential order; may be repeated.")]
_Kz = Annotated[
    str | None, typer.Option("--kz", help="Wave number in z, e.g. pi/2; none: plane strain.")
]
_EA = Annotated[str, typer.Option("--E-a", help="Young's modulus of body a.")]
_NuA = Annotated[str, typer.Option("--nu-a", help="Poisson's ratio of body a.")]
_RhoA = Annotated[str, typer.Option("--rho-a", help="Density of body a.")]
_EB = Annotated[str, typer.Option("--E-b", help="Young's modulus of body b.")]
_NuB = Annotated[str, typer.Option("--nu-b", help="Poisson's ratio of body b.")]
_RhoB = Annotated[str, typer.Option("--rho-b", help="Density of body b.")]
_Inner = Annotated[str, typer.Option("--inner", help="Inner radius.")]
_Interface = Annotated[str, typer.Option("--interface", help="Radius of the interface.")]
_Outer = Annotated[str, typer.Option("--outer", help="Outer radius.")]
_HeightA = Annotated[str, typer.Option("--height-a", help="Thickness of body a.")]
_HeightB = Annotated[str, typer.Option("--height-b", help="Thickness of body b.")]
_Max = Annotated[
    float | None,
    typer.Option("--max-frequency", help="List all eigenvalues with Im up to this, Re to half."),
]
_Count = Annotated[int | None, typer.Option("--count", help="Or: list so many, lowest first.")]


def _writable(file: Path | None) -> Path | None:
    """Refuse a file that cannot be written before work begins."""
    if file is not None:
        check_writable(file, "json")
    return file


_Json = Annotated[
    Path | None, typer.Option("--json", callback=_writable, help="File for the entries.")
]


@app.command()
def drum(
    m: _M,
    p: _P = "1",
    mu: _Mu = "0.3",
    kz: _Kz = None,
    E_a: _EA = "0.1",
    nu_a: _NuA = "0.25",
    rho_a: _RhoA = "0.35",
    E_b: _EB = "1",
    nu_b: _NuB = "0.3",
    rho_b: _RhoB = "1",
    inner: _Inner = "0.5",
    interface: _Interface = "1",
    outer: _Outer = "1.5",
    max_frequency: _Max = None,
    count: _Count = None,
    json: _Json = None,
) -> None:
    """Annulus a around annulus b, clamped outside and inside, in plane strain or 3D (--kz)."""
    from exact_cea import entries
    from exact_cea.drum import Drum

    a, b = _materials(E_a, nu_a, rho_a, E_b, nu_b, rho_b)
    window = _window(max_frequency, count, 14)
    problems = [Drum.of(order, p, mu, kz, a, b, inner, interface, outer) for order in m]
    _deliver([entries.drum(problem, *window) for problem in problems], json)


@app.command()
def blocks(
    p: _P = "1",
    mu0: Annotated[
        str | None, typer.Option("--mu0", help="Friction mu0 sin(pi x / length) [0.3].")
    ] = None,
    mu: Annotated[str | None, typer.Option("--mu", help="Or: constant friction.")] = None,
    thresholds: Annotated[
        bool, typer.Option("--thresholds", help="Instead: exceptional points up to mu0.")
    ] = False,
    kz: _Kz = None,
    E_a: _EA = "0.1",
    nu_a: _NuA = "0.25",
    rho_a: _RhoA = "0.35",
    E_b: _EB = "1",
    nu_b: _NuB = "0.3",
    rho_b: _RhoB = "1",
    height_a: _HeightA = "0.5",
    height_b: _HeightB = "1",
    length: Annotated[str, typer.Option("--length", help="Distance of the roller walls.")] = "2",
    max_frequency: _Max = None,
    count: _Count = None,
    json: _Json = None,
) -> None:
    """Layer a on layer b between roller walls, with sinusoidal or constant friction."""
    from exact_cea import entries
    from exact_cea.blocks import Blocks

    if mu is not None and (mu0 is not None or thresholds):
        raise InputError("mu", mu, "not together with mu0 or thresholds")
    a, b = _materials(E_a, nu_a, rho_a, E_b, nu_b, rho_b)
    default = "1" if thresholds else "0.3"
    friction = next(value for value in (mu, mu0, default) if value is not None)
    problem = Blocks.of(p, friction, kz, a, b, height_a, height_b, length)
    if thresholds:
        if max_frequency is None or count is not None:
            raise InputError("max_frequency", max_frequency, "given, without count, for thresholds")
        _deliver(entries.thresholds(problem, float(problem.mu0), max_frequency), json)
        return
    window = _window(max_frequency, count, 11)
    make = entries.blocks_sine if mu is None else entries.blocks_constant
    _deliver([make(problem, *window)], json)


@app.command()
def ring(
    m: _M,
    p: _P = "1e12",
    mu: _Mu = "0.3",
    E_a: _EA = "1e10",
    nu_a: _NuA = "0.25",
    rho_a: _RhoA = "2500",
    E_b: _EB = "2.1e11",
    nu_b: _NuB = "0.3",
    rho_b: _RhoB = "7800",
    inner: _Inner = "0.08",
    outer: _Outer = "0.16",
    height_a: _HeightA = "0.01",
    height_b: _HeightB = "0.02",
    max_frequency: _Max = None,
    count: _Count = None,
    json: _Json = None,
) -> None:
    """Ring pad a on disc b with rolling rims, by a Galerkin method of high degree."""
    from exact_cea import entries
    from exact_cea.galerkin_problems import Ring

    a, b = _materials(E_a, nu_a, rho_a, E_b, nu_b, rho_b)
    window = _window(max_frequency, count, 20)
    problems = [Ring.of(order, p, mu, a, b, inner, outer, height_a, height_b) for order in m]
    _deliver([entries.ring(problem, *window) for problem in problems], json)


@app.command(name="lumped")
def lumped_(
    model: Annotated[str, typer.Argument(help="hoffmann or hulten.")],
    mu: _Mu = "0.3",
    k11: Annotated[str, typer.Option("--k11", help="hoffmann: stiffness.")] = "2.5",
    k12: Annotated[str, typer.Option("--k12", help="hoffmann: coupling.")] = "0.5",
    k22: Annotated[str, typer.Option("--k22", help="hoffmann: stiffness.")] = "2",
    k3: Annotated[str, typer.Option("--k3", help="hoffmann: of the contact.")] = "4/3",
    k1: Annotated[str, typer.Option("--k1", help="hulten: stiffness of contact 1.")] = "1",
    k2: Annotated[str, typer.Option("--k2", help="hulten: stiffness of contact 2.")] = "1.44",
    c1: Annotated[str, typer.Option("--c1", help="hulten: damping of contact 1.")] = "0",
    c2: Annotated[str, typer.Option("--c2", help="hulten: damping of contact 2.")] = "0",
    rotation: Annotated[str, typer.Option("--rotation", help="hulten: speed of the frame.")] = "0",
    json: _Json = None,
) -> None:
    """Systems of two degrees of freedom: the models of Hoffmann and of Hulten."""
    from exact_cea import entries, lumped

    if model == "hoffmann":
        stiffness = k11, k12, k22, k3
        info = {"mu_c": str(float(lumped.hoffmann_threshold(*stiffness)))}
        system = lumped.hoffmann(mu, *stiffness)
    elif model == "hulten":
        system = lumped.hulten(mu, k1, k2, c1, c2, rotation)
        info = {}
        if not lumped.rationals(rotation=rotation)[0]:
            mu_c, omega2 = lumped.hulten_threshold(k1, k2, c1, c2)
            info = {
                "mu_c": mu_c.str(22, radius=False),
                "omega_c2": omega2.str(22, radius=False),
            }
    else:
        raise InputError("model", model, "hoffmann or hulten")
    _deliver([entries.lumped_system(system, info)], json)


def _materials(
    E_a: str, nu_a: str, rho_a: str, E_b: str, nu_b: str, rho_b: str
) -> "tuple[Material, Material]":
    from exact_cea.material import Material

    return Material.of(E_a, nu_a, rho_a, "a"), Material.of(E_b, nu_b, rho_b, "b")


def _window(
    max_frequency: float | None, count: int | None, default: int
) -> tuple[float | None, int | None]:
    if max_frequency is None and count is None:
        return None, default
    return max_frequency, count


_NOT_IN_LINE = {
    *("lam", "lam_contact_free", "digits_each", "M", "C", "K"),
    *("window", "a", "b", "sizes"),
}
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
