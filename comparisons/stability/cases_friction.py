"""Friction and the spectra it makes: growth, divergence, copies, whole windows."""

from functools import partial
from math import inf
from typing import Any

import numpy as np

from comparisons.stability.case import (
    ACCURATE,
    HONEST,
    MESH,
    NONE,
    Runs,
    refused,
    runs,
)
from comparisons.stability.problems import OfMap
from comparisons.stability.references import dense
from comparisons.stability.scenes import (
    ABOUT_Z,
    HELD_ABOVE,
    HELD_BELOW,
    LINING,
    STEEL,
    Scene,
    body,
    changed,
    contact,
    in_units,
    layers,
    pad,
    patch,
    rectangle,
    scene,
    sprag,
    unequal_boxes,
    up_to,
)
from comparisons.stability.ways import ALONE, FEW, PAIR, SADDLE, WAYS, Backend, chosen

_SIMPLE = chosen(WAYS, "GPTS, penalty", "mortar")


def friction() -> Runs:
    """Friction 0, 1e-12, 0.3, 1, 5, oscillating."""
    values: dict[str, float | str] = {f"μ = {mu:g}": mu for mu in (0.0, 1e-12, 0.3, 1.0, 5.0)}
    values["μ oscillates"] = "0.5*abs(sin(40*pi*x))"
    for row, mu in values.items():
        yield from runs(row, layers(mu=mu, p=10.0))
    yield from refused("μ changes sign", layers(mu="0.5*sin(5*pi*x)"), PAIR, "mu")


def sprags() -> Runs:
    """Sprags: divergence and flutter at any friction."""
    for angle, mu in ((60.0, 0.3), (60.0, 0.7), (60.0, 2.0), (80.0, 0.5), (80.0, 5.0)):
        for p in (1.0, 1e4):
            row = f"{angle:g} degrees, μ = {mu:g}, p = {p:.0e}"
            yield from runs(row, sprag(angle, mu, p=p), lowest=6)


def slow() -> Runs:
    """Systems with frequencies of 1e-6 to 1e6 Hz."""
    fast = sprag(mu=1.0)
    for factor in (1e-6, 1e-3, 1e3, 1e6):
        heavier = {f"bodies.{name}.material.rho": factor**2 for name in fast["bodies"]}
        true, row = partial(dense, factor=1 / factor), f"{factor:.0e} times slower"
        yield from runs(row, changed(fast, heavier), _SIMPLE, true, instead=fast)


def arms() -> Runs:
    """Oblique arms: divergence, strong flutter, copies of zero."""
    # What is easily missed, window's end (Hz); width, lean and height of the arm, its elements and
    # fields; size, elements and supports of the ground; p and mu.
    stiff = {"E": 100.0, "supports": [{"surface": "head"}]}
    large, small = ((6.0, 3.0), (15, 6), HELD_BELOW), ((2.0, 1.0), (9, 4), HELD_BELOW)
    foot, other = (0.2, 0.36397023426620236, 1.0), (0.25, -0.2151833689734136, 1.39)
    third = (0.55, 0.4549995702848617, 0.55)
    rows: list[tuple[str, float, Any, Any, Scene, Any, float, float]] = [
        ("divergence of 3.35", 0.5, foot, (3, 8), stiff, large, 1e4, 1.0),
        ("flutter of 4.56", 0.4, other, (5, 4), {}, small, 98036.108, 2.75),
        ("a copy of zero", 1.29, third, (5, 2), {}, (*small[:2], ()), 531.164, 0.5),
    ]
    for row, end, (width, lean, height), elements, arm, (size, grid, held), p, mu in rows:
        half = width / 2
        shape = patch([[-half, 0.0], [half, 0.0]], [[lean - half, height], [lean + half, height]])
        ground = rectangle(size, (-size[0] / 2, -size[1]))
        bodies = {
            "arm": body(shape, elements, **arm),
            "base": body(ground, grid, E=10.0, supports=held),
        }
        data = scene(bodies, contact=contact("arm.foot", "base.y_max", p=p, mu=mu))
        yield from runs(row, up_to(end, data), chosen(WAYS, backend="iga"), tolerance=1e-6)


def _times(number: int, one: Scene) -> Scene:
    """So many copies in one place of a scene of at most one contact."""
    contacts = {
        f"c{i}": each | {side: each[side].replace(".", f"{i}.") for side in ("a", "b")}
        for each in one["contacts"].values()
        for i in range(number)
    }
    bodies = {f"{name}{i}": each for name, each in one["bodies"].items() for i in range(number)}
    return scene(bodies, **contacts)


def _pair(mu: float) -> Scene:
    """A square that slides on another."""
    upper = body(rectangle((1.0, 1.0)), (1, 1), supports=HELD_ABOVE)
    lower = body(rectangle((1.0, 1.0), (0.0, -1.0)), (2, 1), E=0.7, supports=HELD_BELOW)
    return scene({"u": upper, "l": lower}, c=contact("u.y_min", "l.y_max", mu=mu))


def clusters() -> Runs:
    """Clusters of 20 equal eigenvalues, with and without friction."""
    square = scene({"b": body(rectangle((1.0, 1.0)), (2, 2), supports=HELD_BELOW)})
    for row, number, one, ways, lowest in (
        ("20 squares", 20, square, ALONE, 60),
        ("20 pairs, μ = 0", 20, _pair(0.0), _SIMPLE, 40),
        ("20 pairs, μ = 0.3", 20, _pair(0.3), _SIMPLE, 40),
        ("5 sprags", 5, sprag(mu=1.0), _SIMPLE, 15),
    ):
        true, may = partial(dense, copies=number), (*MESH, "bodies-overlap")
        fields: dict[str, Any] = {"instead": one, "lowest": lowest, "warnings": may}
        yield from runs(row, _times(number, one), ways, true, **fields)


def disc_pad() -> Runs:
    """Disc and pad, friction to 2.5, P to 1e13 N/m."""
    sector = {"shape": "sector", "start": 25.0, "end": 65.0, "bottom": 0.012, "top": 0.027}
    annulus = {"shape": "annulus", "inner_radius": 0.06, "outer_radius": 0.15}
    pad_at = sector | {"inner_radius": 0.09, "outer_radius": 0.14}
    disc_at = annulus | {"bottom": 0.0, "top": 0.012}
    lining: Scene = {"E": 8e9, "rho": 2500.0, "supports": [{"surface": "top"}]}
    steel: Scene = {"E": 2.1e11, "rho": 7800.0, "supports": [{"surface": "inner"}]}
    meshes: list[tuple[Backend, int, tuple[int, int, int]]]
    meshes = [("fe", 1, (3, 20, 1)), ("iga", 2, (2, 12, 1))]
    for mu, P in ((0.0, 1e9), (0.7, 1e9), (2.5, 1e11), (2.5, 1e13)):
        sliding = {"P": P, "mu": mu, "max_missed": 0.2, "friction_direction_on_a": ABOUT_Z}
        for backend, degree, elements in meshes:
            bodies = {
                "pad": body(pad_at, (2, 3, 1), degree=degree, **lining),
                "disc": body(disc_at, elements, degree=degree, **steel),
            }
            data = scene(bodies, contact=contact("pad.bottom", "disc.top", **sliding))
            ways, row = chosen(FEW, backend=backend), f"μ = {mu:g}, P = {P:.0e} N/m"
            yield from runs(row, data, ways, tolerance=1e-7)


def _fine(**fields: Any) -> Scene:
    return layers(upper_elements=(8, 3), lower_elements=(7, 4), **fields)


_FREE_BLOCK = scene({"block": body(rectangle((2.0, 1.0)), (4, 3))})


def everyday() -> Runs:
    """Everyday scenes: accurate, and free of warnings."""
    brake = _fine(upper=LINING, lower=STEEL, p=1e11)
    for row, data in {
        "layers": _fine(),
        "layers without friction": _fine(mu=0.0),
        "layers, friction 0.7": _fine(mu=0.7),
        "steel on lining, SI": brake,
        "steel on lining, mm-t-s": in_units(brake, metre=1e3, kilogram=1e-3),
        "pad": pad(),
        "sprag below its limit": sprag(60.0, 0.3),
        "sprag beyond its limit": sprag(60.0, 0.9),
    }.items():
        ways = (*FEW, *chosen(WAYS, "GPTS, full"))
        yield from runs(row, data, ways, lowest=3, warnings=NONE)
    yield from runs("free block", _FREE_BLOCK, ALONE, lowest=5, warnings=NONE)


def free_bodies() -> Runs:
    """Free bodies: rigid motions."""
    yield from runs("one block", _FREE_BLOCK, ALONE, tolerance=1e-6)
    lower = body(rectangle((2.0, 1.0), (0.0, -1.0)), (4, 2))
    bodies = {"upper": body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2), E=0.5), "lower": lower}
    for mu in (0.0, 0.3, 1.5):
        for name, data in (
            ("plane", scene(bodies, contact=contact("upper.y_min", "lower.y_max", p=2.0, mu=mu))),
            ("space", unequal_boxes(held=False, mu=mu)),
        ):
            yield from runs(f"two blocks, {name}, μ = {mu:g}", data, FEW, tolerance=1e-6, lowest=10)


def maps() -> Runs:
    """Maps of friction and contact stiffness by a reduced model."""
    for P, mu, ends, ways in (
        *((P, mu, (1e-3, 1e5), PAIR) for P, mu in ((0.02, 0.3), (7.0, 0.83), (3e3, 0.61))),
        (2e11, 0.83, (1e6, 1e14), chosen(SADDLE, "GPTS, saddle", "mortar")),
    ):
        axes = {
            "contacts.interface.mu": (0.0, 0.5, 1.0),
            "contacts.interface.P": np.geomspace(*ends, 9).tolist(),
        }
        row, data = f"P = {P:g} N/m, μ = {mu:g}", layers(P=P, mu=mu)
        fields: dict[str, Any] = {"expected": HONEST if P > 1e6 else ACCURATE}
        yield from runs(row, data, ways, problem=partial(OfMap, axes=axes), **fields)


def whole_spectrum() -> Runs:
    """Windows that hold the whole spectrum."""

    def few(**fields: Any) -> Scene:
        return layers(upper_elements=(3, 2), lower_elements=(2, 2), **fields)

    for name, P, data in (
        *(("just", P, few(P=P)) for P in (1.0, inf)),
        *(("far beyond", P, up_to(1e3, few(P=P))) for P in (1.0, inf)),
    ):
        ways = FEW if P == 1 else tuple(way for way in FEW if way in SADDLE)
        yield from runs(f"{name} all modes, P = {P:g}", data, ways, lowest=10_000)
    yield from runs("all modes, no friction", up_to(1e3, few(P=1.0, mu=0.0)), ALONE)
