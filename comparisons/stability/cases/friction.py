"""Friction and the spectra it makes: growth, divergence, copies, whole windows, maps."""

from collections.abc import Iterator
from functools import partial
from math import inf
from typing import Any

import numpy as np
from scipy.linalg import block_diag, qr

from cea.arrays import Floats
from comparisons.stability.parts.case import (
    ACCURATE,
    HONEST,
    MESH,
    NONE,
    WARNED,
    Case,
    Rows,
    Run,
    refused,
)
from comparisons.stability.parts.dense import lambdas
from comparisons.stability.parts.problems import OfMap, OfMatrices
from comparisons.stability.parts.references import benign, copies, formula
from comparisons.stability.parts.scenes import (
    ABOUT_Z,
    HELD_ABOVE,
    HELD_BELOW,
    LINING,
    STEEL,
    Scene,
    body,
    boxes,
    changed,
    contact,
    in_units,
    layers,
    pad,
    patch,
    rectangle,
    scene,
    sprag,
    up_to,
)
from comparisons.stability.parts.ways import ALONE, FEW, PAIR, SADDLE, WAYS, Backend, chosen

SUBJECT = "friction and spectra"
_SIMPLE = chosen(WAYS, "GPTS, penalty", "mortar")


def _arm(
    foot: tuple[float, float, float],
    elements: tuple[int, int],
    ground: Scene,
    arm: dict[str, Any] | None = None,
    **fields: Any,
) -> Scene:
    """An arm on a base; ``foot`` is its width, by how much it leans, and its height."""
    width, lean, height = foot
    half = width / 2
    shape = patch([[-half, 0.0], [half, 0.0]], [[lean - half, height], [lean + half, height]])
    bodies = {"arm": body(shape, elements, **(arm or {})), "base": ground}
    return scene(bodies, contact=contact("arm.foot", "base.y_max", **fields))


def _ground(size: tuple[float, float], elements: tuple[int, int], *, held: bool = True) -> Scene:
    supports = HELD_BELOW if held else []
    return body(rectangle(size, (-size[0] / 2, -size[1])), elements, E=10.0, supports=supports)


_STIFF_ARM = {"E": 100.0, "supports": [{"surface": "head"}]}
_LARGE, _SMALL = ((6.0, 3.0), (15, 6)), ((2.0, 1.0), (9, 4))
_ARMS = {
    "divergence of 3.35": up_to(
        0.5,
        _arm((0.2, 0.36397023426620236, 1.0), (3, 8), _ground(*_LARGE), _STIFF_ARM, p=1e4, mu=1.0),
    ),
    "flutter of 4.56": up_to(
        0.4,
        _arm((0.25, -0.2151833689734136, 1.39), (5, 4), _ground(*_SMALL), p=98036.108, mu=2.75),
    ),
    "a copy of zero": up_to(
        1.29,
        _arm(
            *((0.55, 0.4549995702848617, 0.55), (5, 2), _ground(*_SMALL, held=False)),
            p=531.164,
            mu=0.5,
        ),
    ),
}
"""Oblique arms by what is easily missed of their modes."""


def _squares(number: int) -> Scene:
    """Equal squares, each on its own ground."""
    square = body(rectangle((1.0, 1.0)), (2, 2), supports=HELD_BELOW)
    return scene({f"b{i}": square for i in range(number)})


def _pairs(number: int, mu: float) -> Scene:
    """Equal pairs of a square that slides on another."""
    upper = body(rectangle((1.0, 1.0)), (1, 1), supports=HELD_ABOVE)
    lower = body(rectangle((1.0, 1.0), (0.0, -1.0)), (2, 1), E=0.7, supports=HELD_BELOW)
    bodies = {f"u{i}": upper for i in range(number)} | {f"l{i}": lower for i in range(number)}
    contacts = {f"c{i}": contact(f"u{i}.y_min", f"l{i}.y_max", mu=mu) for i in range(number)}
    return scene(bodies, **contacts)


def _sprags(number: int) -> Scene:
    """Equal sprags, all of which diverge."""
    one = sprag(mu=1.0)
    bodies = {f"{name}{i}": each for i in range(number) for name, each in one["bodies"].items()}
    sides = [{"a": f"block{i}.y_min", "b": f"base{i}.y_max"} for i in range(number)]
    contacts = {f"c{i}": one["contacts"]["contact"] | each for i, each in enumerate(sides)}
    return scene(bodies, **contacts)


_IN_ONE_PLACE = (*MESH, "bodies-overlap")
"""Copies lie where the others do."""


def _disc_pad(mu: float, P: float) -> list[Rows]:
    """Modes that grow by 1e5 1/s, far from the frequencies looked at."""
    pad_at = {"inner_radius": 0.09, "outer_radius": 0.14, "bottom": 0.012, "top": 0.027}
    disc_at = {"inner_radius": 0.06, "outer_radius": 0.15, "bottom": 0.0, "top": 0.012}

    def made(degree: int, elements: tuple[int, int, int]) -> Scene:
        lining: Scene = {"E": 8e9, "rho": 2500.0, "supports": [{"surface": "top"}]}
        steel: Scene = {"E": 2.1e11, "rho": 7800.0, "supports": [{"surface": "inner"}]}
        sector = {"shape": "sector", "start": 25.0, "end": 65.0, **pad_at}
        sliding = {"P": P, "mu": mu, "max_missed": 0.2, "friction_direction_on_a": ABOUT_Z}
        return scene(
            {
                "pad": body(sector, (2, 3, 1), degree=degree, **lining),
                "disc": body({"shape": "annulus", **disc_at}, elements, degree=degree, **steel),
            },
            contact=contact("pad.bottom", "disc.top", **sliding),
        )

    row = f"μ = {mu:g}, P = {P:.0e} N/m"
    meshes: list[tuple[Backend, int, tuple[int, int, int]]]
    meshes = [("fe", 1, (3, 20, 1)), ("iga", 2, (2, 12, 1))]
    return [
        Rows({row: made(degree, elements)}, chosen(FEW, backend=backend), tolerance=1e-7)
        for backend, degree, elements in meshes
    ]


def _fine(**fields: Any) -> Scene:
    return layers(upper_elements=(8, 3), lower_elements=(7, 4), **fields)


_BRAKE = _fine(upper=LINING, lower=STEEL, p=1e11)
_EVERYDAY = {
    "layers": _fine(),
    "layers without friction": _fine(mu=0.0),
    "layers, friction 0.7": _fine(mu=0.7),
    "steel on lining, SI": _BRAKE,
    "steel on lining, mm-t-s": in_units(_BRAKE, metre=1e3, kilogram=1e-3),
    "pad": pad(),
    "sprag below its limit": sprag(60.0, 0.3),
    "sprag beyond its limit": sprag(60.0, 0.9),
}
_FREE_BLOCK = scene({"block": body(rectangle((2.0, 1.0)), (4, 3))})


def _free_blocks(mu: float) -> Scene:
    lower = body(rectangle((2.0, 1.0), (0.0, -1.0)), (4, 2))
    return scene(
        {"upper": body(rectangle((1.0, 0.5), (0.3, 0.0)), (3, 2), E=0.5), "lower": lower},
        contact=contact("upper.y_min", "lower.y_max", p=2.0, mu=mu),
    )


def _free_boxes(mu: float) -> Scene:
    sizes: dict[str, tuple[Any, ...]] = {
        "upper": ([1.0, 0.8, 0.5], [0.3, 0.1, 0.0], (2, 2, 1), 0.5, []),
        "lower": ([2.0, 1.0, 1.0], [0.0, 0.0, -1.0], (2, 2, 1), 1.0, []),
    }
    return boxes(sizes, p=2.0, mu=mu)


def _exceptional_point() -> Iterator[Run]:
    """Hoffmann's model beyond mu_c (1 + d) grows by about sqrt(d); below it does not grow."""
    k11, k12, k22, k3 = 2.5, 0.5, 2.0, 4 / 3
    critical = ((k11 - k22) ** 2 + 4 * k12**2) / (4 * k12 * k3)
    others = np.linspace(0.6, 4.0, 6)  # kappa of unknowns that are coupled to nothing
    for side, word in ((1.0, "beyond"), (-1.0, "before")):
        for distance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
            # kappa = 2.25 -+ sqrt(-d (k11 - k22)^2 / 4 - d k12^2)
            split = -side * distance * ((k11 - k22) ** 2 / 4 + k12**2)
            root, middle = np.sqrt(complex(split)), 0.5 * (k11 + k22)
            true = lambdas(np.array([middle - root, middle + root, *others]))
            friction = np.zeros((8, 8))
            friction[0, 1] = critical * (1 + side * distance) * k3
            stiffness = block_diag([[k11, k12], [k12, k22]], np.diag(others))
            yield Run(
                f"{word} it by {distance:.0e}",
                ALONE[0],
                OfMatrices(stiffness, np.eye(8), friction),
                formula(true.tolist()),
                ACCURATE if distance > 1e-6 else WARNED,
                lowest=7,
                warnings=NONE,
            )


def _multiplicities() -> Iterator[Run]:
    """Copies are found however many there are, and whatever grows beside them."""
    beyond = np.linspace(20.0, 1e4, 60)  # kappa beyond the window
    for number in (2, 5, 13, 30):
        for word, mu in {"stable": 0.0, "fluttering": 0.3, "diverging": 2.0}.items():
            block = np.array([[1.0, 0.0], [0.0, 1.1]])
            friction = np.array([[0.0, mu], [-mu if word == "fluttering" else mu, 0.0]])
            kappas = np.linalg.eigvals(block - friction)
            S = block_diag(*[block] * number, np.diag(beyond))
            F = block_diag(*[friction] * number, np.zeros((len(beyond), len(beyond))))
            turn: Floats = qr(np.random.default_rng(1).standard_normal(S.shape))[0]
            turned = turn.T @ S @ turn
            true = lambdas(np.concatenate([np.repeat(kappas, number), beyond]))
            yield Run(
                f"{number} copies, {word}",
                ALONE[0],
                OfMatrices(0.5 * (turned + turned.T), np.eye(len(S)), turn.T @ F @ turn),
                formula(true.tolist()),
                lowest=2 * number,
                warnings=NONE,
            )


def _map(P: float, mu: float, ends: tuple[float, float], ways: Any, **options: Any) -> Rows:
    """A value of a map of mu and P, between the full solves that it rests on."""
    axes = {
        "contacts.interface.mu": (0.0, 0.5, 1.0),
        "contacts.interface.P": tuple(np.geomspace(*ends, 9).tolist()),
    }
    row = {f"P = {P:g} N/m, μ = {mu:g}": layers(P=P, mu=mu)}
    return Rows(row, ways, problem=partial(OfMap, axes=axes), **options)


def _slowed(factor: float) -> Rows:
    """Everything takes so many times longer."""
    fast = sprag(mu=1.0)
    heavier = {f"bodies.{name}.material.rho": factor**2 for name in fast["bodies"]}
    row = {f"{factor:.0e} times slower": changed(fast, heavier)}
    return Rows(row, _SIMPLE, partial(benign, factor=1 / factor), instead=fast)


def _few(**fields: Any) -> Scene:
    return layers(upper_elements=(3, 2), lower_elements=(2, 2), **fields)


def _all_modes(name: str, P: float, data: Scene) -> Rows:
    ways = FEW if P == 1 else tuple(way for way in FEW if way in SADDLE)
    return Rows({f"{name} all modes, P = {P:g}": data}, ways, lowest=10_000)


_FRICTIONS: dict[str, float | str] = {
    "μ = 0": 0.0,
    "μ = 1e-12": 1e-12,
    "μ = 0.3": 0.3,
    "μ = 1": 1.0,
    "μ = 5": 5.0,
    "μ oscillates": "0.5*abs(sin(40*pi*x))",
}

CASES = {
    "arms": Case(
        "Oblique arms: divergence, strong flutter, copies of zero",
        Rows(_ARMS, chosen(WAYS, backend="iga"), tolerance=1e-6),
    ),
    "clusters": Case(
        "Clusters of 20 equal eigenvalues, with and without friction",
        Rows(
            {"20 squares": _squares(20)},
            ALONE,
            partial(copies, 20),
            instead=_squares(1),
            lowest=60,
            warnings=_IN_ONE_PLACE,
        ),
        *(
            Rows(
                {f"20 pairs, μ = {mu:g}": _pairs(20, mu)},
                _SIMPLE,
                partial(copies, 20),
                instead=_pairs(1, mu),
                lowest=40,
                warnings=_IN_ONE_PLACE,
            )
            for mu in (0.0, 0.3)
        ),
        Rows(
            {"5 sprags": _sprags(5)},
            _SIMPLE,
            partial(copies, 5),
            instead=_sprags(1),
            lowest=15,
            warnings=_IN_ONE_PLACE,
        ),
    ),
    "disc_pad": Case(
        "Disc and pad, friction to 2.5, P to 1e13 N/m",
        *(
            rows
            for mu, P in ((0.0, 1e9), (0.7, 1e9), (2.5, 1e11), (2.5, 1e13))
            for rows in _disc_pad(mu, P)
        ),
    ),
    "everyday": Case(
        "Everyday scenes: accurate, and free of warnings",
        Rows(_EVERYDAY, (*FEW, *chosen(WAYS, "GPTS, full")), lowest=3, warnings=NONE),
        Rows({"free block": _FREE_BLOCK}, ALONE, lowest=5, warnings=NONE),
    ),
    "exceptional_point": Case(
        "Hoffmann's model at 1e-2 to 1e-14 from its coalescence", _exceptional_point
    ),
    "free_bodies": Case(
        "Free bodies: rigid motions",
        Rows({"one block": _FREE_BLOCK}, ALONE, tolerance=1e-6),
        Rows(
            {
                f"two blocks, {name}, μ = {mu:g}": make(mu)
                for mu in (0.0, 0.3, 1.5)
                for name, make in (("plane", _free_blocks), ("space", _free_boxes))
            },
            FEW,
            tolerance=1e-6,
            lowest=10,
        ),
    ),
    "friction": Case(
        "Friction 0, 1e-12, 0.3, 1, 5, oscillating",
        Rows({name: layers(mu=mu, p=10.0) for name, mu in _FRICTIONS.items()}),
        refused({"μ changes sign": layers(mu="0.5*sin(5*pi*x)")}, PAIR, "mu"),
    ),
    "maps": Case(
        "Maps of friction and contact stiffness by a reduced model",
        *(_map(P, mu, (1e-3, 1e5), PAIR) for P, mu in ((0.02, 0.3), (7.0, 0.83), (3e3, 0.61))),
        _map(
            *(2e11, 0.83, (1e6, 1e14)),
            chosen(SADDLE, "GPTS, saddle", "mortar, saddle"),
            expected=HONEST,
        ),
    ),
    "multiplicities": Case("Eigenvalues 2 to 30 times in given matrices", _multiplicities),
    "slow": Case(
        "Systems with frequencies of 1e-6 to 1e6 Hz",
        *(_slowed(factor) for factor in (1e-6, 1e-3, 1e3, 1e6)),
    ),
    "sprags": Case(
        "Sprags: divergence and flutter at any friction",
        Rows(
            {
                f"{angle:g} degrees, μ = {mu:g}, p = {p:.0e}": sprag(angle, mu, p=p)
                for angle, mu in ((60.0, 0.3), (60.0, 0.7), (60.0, 2.0), (80.0, 0.5), (80.0, 5.0))
                for p in (1.0, 1e4)
            },
            lowest=6,
        ),
    ),
    "whole_spectrum": Case(
        "Windows that hold the whole spectrum",
        *(_all_modes("just", P, _few(P=P)) for P in (1.0, inf)),
        *(_all_modes("far beyond", P, up_to(1e3, _few(P=P))) for P in (1.0, inf)),
        Rows({"all modes, no friction": up_to(1e3, _few(P=1.0, mu=0.0))}, ALONE),
    ),
}
