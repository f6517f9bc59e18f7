"""Cases of friction: growth, divergence, multiple eigenvalues, whole spectra."""

from functools import partial
from math import inf
from typing import Any

import numpy as np

from comparisons.stability.case import Runs, dense, refused, runs
from comparisons.stability.problems import of_map
from comparisons.stability.scenes import (
    FINE,
    LINING,
    STEEL,
    Scene,
    body,
    changed,
    coarse,
    contact,
    in_units,
    layers,
    pad,
    patch,
    rectangle,
    scene,
    sprag,
    stacked,
    unequal_boxes,
    up_to,
)
from comparisons.stability.ways import ALONE, FEW, PAIR, SADDLE, WAYS, chosen

_SIMPLE = chosen(WAYS, "GPTS, penalty", "mortar")


def friction() -> Runs:
    """Friction 0, 1e-12, 0.3, 1, 5, oscillating."""
    rows = {f"μ = {mu:g}": layers(mu=mu, p=10.0) for mu in (0.0, 1e-12, 0.3, 1.0, 5.0)}
    rows["μ oscillates"] = layers(mu="0.5*abs(sin(40*pi*x))", p=10.0)
    yield from runs(rows)
    yield from refused({"μ changes sign": layers(mu="0.5*sin(5*pi*x)")}, PAIR, "mu")


def sprags() -> Runs:
    """Sprags: divergence and flutter at any friction."""
    for angle, mu in ((60.0, 0.3), (60.0, 0.7), (60.0, 2.0), (80.0, 0.5), (80.0, 5.0)):
        for p in (1.0, 1e4):
            row = f"{angle:g} degrees, μ = {mu:g}, p = {p:.0e}"
            yield from runs({row: sprag(angle, mu, p=p)}, lowest=6)


def slow() -> Runs:
    """Systems with frequencies of 1e-6 to 1e6 Hz."""
    fast = sprag(mu=1.0)
    for factor in (1e-6, 1e-3, 1e3, 1e6):
        heavier = {f"bodies.{name}.material.rho": factor**2 for name in fast["bodies"]}
        rows = {f"{factor:.0e} times slower": changed(fast, heavier)}
        yield from runs(rows, _SIMPLE, partial(dense, factor=1 / factor), instead=fast)


def arms() -> Runs:
    """Oblique arms: divergence, strong flutter, multiple zero eigenvalues."""
    stiff = {"E": 100.0, "held": "head"}
    large, small = rectangle((6.0, 3.0), (-3.0, -3.0)), rectangle((2.0, 1.0), (-1.0, -1.0))

    def arm(width: float, lean: float, height: float, *elements: int, **fields: Any) -> Scene:
        half = width / 2
        shape = patch([[-half, 0.0], [half, 0.0]], [[lean - half, height], [lean + half, height]])
        return body(shape, elements, **fields)

    def ground(shape: Scene, *elements: int, held: str = "y_min") -> Scene:
        return body(shape, elements, E=10.0, held=held)

    first = arm(0.2, 0.36397023426620236, 1.0, 3, 8, **stiff), ground(large, 15, 6)
    second = arm(0.25, -0.2151833689734136, 1.39, 5, 4), ground(small, 9, 4)
    third = arm(0.55, 0.4549995702848617, 0.55, 5, 2), ground(small, 9, 4, held="")
    for row, end, (upper, lower), p, mu in (  # what is easily missed, the end of the window (Hz)
        ("divergence of 3.35", 0.5, first, 1e4, 1.0),
        ("flutter of 4.56", 0.4, second, 98036.108, 2.75),
        ("a copy of zero", 1.29, third, 531.164, 0.5),
    ):
        sliding = contact("arm.foot", "base.y_max", p=p, mu=mu)
        data = up_to(end, scene({"arm": upper, "base": lower}, contact=sliding))
        yield from runs({row: data}, chosen(WAYS, backend="iga"), tolerance=1e-6)


def _times(number: int, one: Scene) -> Scene:
    """``number`` copies of a scene of at most one contact, all in one place."""
    contacts = {
        f"c{i}": each | {side: each[side].replace(".", f"{i}.") for side in ("a", "b")}
        for each in one["contacts"].values()
        for i in range(number)
    }
    bodies = {f"{name}{i}": each for name, each in one["bodies"].items() for i in range(number)}
    return scene(bodies, **contacts)


def _pair(mu: float) -> Scene:
    """A square that slides on another."""
    upper = body(rectangle((1.0, 1.0)), (1, 1), held="y_max")
    lower = body(rectangle((1.0, 1.0), (0.0, -1.0)), (2, 1), E=0.7, held="y_min")
    return scene({"u": upper, "l": lower}, c=contact("u.y_min", "l.y_max", mu=mu))


def clusters() -> Runs:
    """Clusters of 20 equal eigenvalues, with and without friction."""
    square = scene({"b": body(rectangle((1.0, 1.0)), (2, 2), held="y_min")})
    for row, number, one, ways, lowest in (
        ("20 squares", 20, square, ALONE, 60),
        ("20 pairs, μ = 0", 20, _pair(0.0), _SIMPLE, 40),
        ("20 pairs, μ = 0.3", 20, _pair(0.3), _SIMPLE, 40),
        ("5 sprags", 5, sprag(mu=1.0), _SIMPLE, 15),
    ):
        may: dict[str, Any] = {"also": ("bodies-overlap",), "lowest": lowest}
        true, rows = partial(dense, copies=number), {row: _times(number, one)}
        yield from runs(rows, ways, true, instead=one, **may)


def disc_pad() -> Runs:
    """Disc and pad, friction to 2.5, P to 1e13 N/m."""
    for mu, P in ((0.0, 1e9), (0.7, 1e9), (2.5, 1e11), (2.5, 1e13)):
        for backend, degree, elements in (("fe", 1, (3, 20, 1)), ("iga", 2, (2, 12, 1))):
            data = coarse("disc_pad", degree, pad=(2, 3, 1), disc=elements)
            data["contacts"]["pad_disc"] |= {"P": P, "mu": mu, "max_missed": 0.2}
            rows = {f"μ = {mu:g}, P = {P:.0e} N/m": data}
            yield from runs(rows, chosen(FEW, backend=backend), tolerance=1e-7)


_FREE_BLOCK = scene({"block": body(rectangle((2.0, 1.0)), (4, 3))})


def everyday() -> Runs:
    """Everyday scenes: accurate, and free of warnings."""
    brake = layers(upper=LINING, lower=STEEL, p=1e11, **FINE)
    rows = {
        "layers": layers(**FINE),
        "layers without friction": layers(mu=0.0, **FINE),
        "layers, friction 0.7": layers(mu=0.7, **FINE),
        "steel on lining, SI": brake,
        "steel on lining, mm-t-s": in_units(brake, metre=1e3, kilogram=1e-3),
        "pad": pad(),
        "sprag below its limit": sprag(60.0, 0.3),
        "sprag beyond its limit": sprag(60.0, 0.9),
    }
    yield from runs(rows, (*FEW, *chosen(WAYS, "GPTS, full")), lowest=3, warnings=())
    yield from runs({"free block": _FREE_BLOCK}, ALONE, lowest=5, warnings=())


def free_bodies() -> Runs:
    """Free bodies: rigid body modes."""
    yield from runs({"one block": _FREE_BLOCK}, ALONE, tolerance=1e-6)
    upper = body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2), E=0.5)
    lower = body(rectangle((2.0, 1.0), (0.0, -1.0)), (4, 2))
    for mu in (0.0, 0.3, 1.5):
        rows = {
            f"two blocks, plane, μ = {mu:g}": stacked(upper, lower, p=2.0, mu=mu),
            f"two blocks, space, μ = {mu:g}": unequal_boxes(held=False, mu=mu),
        }
        yield from runs(rows, FEW, tolerance=1e-6, lowest=10)


def maps() -> Runs:
    """Maps of friction and contact stiffness by a reduced model."""
    for P, mu, ends, ways in (
        (0.02, 0.3, (1e-3, 1e5), PAIR),
        (7.0, 0.83, (1e-3, 1e5), PAIR),
        (3e3, 0.61, (1e-3, 1e5), PAIR),
        (2e11, 0.83, (1e6, 1e14), chosen(SADDLE, "GPTS, saddle", "mortar")),
    ):
        axes = {
            "contacts.interface.mu": (0.0, 0.5, 1.0),
            "contacts.interface.P": np.geomspace(*ends, 9).tolist(),
        }
        rows = {f"P = {P:g} N/m, μ = {mu:g}": layers(P=P, mu=mu)}
        expected = "honest" if P > 1e6 else "accurate"
        yield from runs(rows, ways, problem=partial(of_map, axes=axes), expected=expected)


def whole_spectrum() -> Runs:
    """Windows that hold the whole spectrum."""

    def few(**fields: Any) -> Scene:
        return layers(upper_elements=(3, 2), lower_elements=(2, 2), **fields)

    tied = chosen(SADDLE, "GPTS, saddle", "mortar")
    for row, data, ways in (
        ("just all modes, P = 1", few(P=1.0), FEW),
        ("just all modes, P = inf", few(P=inf), tied),
        ("far beyond all modes, P = 1", up_to(1e3, few(P=1.0)), FEW),
        ("far beyond all modes, P = inf", up_to(1e3, few(P=inf)), tied),
    ):
        yield from runs({row: data}, ways, lowest=10_000)
    yield from runs({"all modes, no friction": up_to(1e3, few(P=1.0, mu=0.0))}, ALONE)
