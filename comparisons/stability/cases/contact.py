"""Contact stiffness from next to nothing to infinity, contact open in part, several contacts."""

from math import inf
from typing import Any

import numpy as np

from comparisons.stability.parts.case import (
    ACCURATE,
    HONEST,
    MESH,
    MESH_AND_PENALTY,
    NONE,
    Case,
    Rows,
    refused,
)
from comparisons.stability.parts.references import benign, exact, formula
from comparisons.stability.parts.scenes import (
    ABOUT_Z,
    HELD_ABOVE,
    HELD_BELOW,
    Scene,
    base,
    body,
    boxes,
    changed,
    contact,
    layers,
    pad,
    rectangle,
    scene,
    up_to,
)
from comparisons.stability.parts.ways import (
    FEW,
    MORTAR,
    OPEN,
    PAIR,
    PENALTY,
    SADDLE,
    WAYS,
    Backend,
    chosen,
    without,
)

SUBJECT = "contact stiffness"
_HARMLESS = 1e6
"""P up to which a penalty keeps the digits of the tolerance, and lumping has a good reference."""
_CUBIC = {"degree": 3}
_MORTAR = chosen(WAYS, "mortar, saddle")


def _fine_layers(p: float, mu: str, upper: Any = (8, 3), lower: Any = (7, 4)) -> Scene:
    """Cubic layers for which exact eigenvalues are known."""
    data = layers(
        upper=_CUBIC, lower=_CUBIC, upper_elements=upper, lower_elements=lower, p=p, mu=mu
    )
    return up_to(0.42, data)


def _exact_layers(p: float, mu: float) -> Any:
    return exact("blocks", max_frequency=0.42, p="inf" if p == inf else p, mu=str(mu))


def _drum(p: float) -> Scene:
    def ring(inner: float, outer: float, elements: tuple[int, int], **fields: Any) -> Scene:
        geometry = {"shape": "ring", "inner_radius": inner, "outer_radius": outer}
        return body(geometry, elements, degree=3, **fields)

    soft = {"E": 0.1, "nu": 0.25, "rho": 0.35, "supports": [{"surface": "outer"}]}
    bodies = {
        "outer": ring(1.0, 1.5, (2, 20), **soft),
        "inner": ring(0.5, 1.0, (2, 16), supports=[{"surface": "inner"}]),
    }
    sliding = contact("outer.inner", "inner.outer", p=p, friction_direction_on_a=ABOUT_Z)
    return up_to(0.33, scene(bodies, interface=sliding))


def _four_blocks(P: float) -> Scene:
    """Two blocks that slide on each other, two bonded on top of them and to each other."""

    def block(x: float, y: float, *supports: Scene) -> Scene:
        return body(rectangle((1.0, 1.0), (x, y)), (4, 4), supports=supports)

    def bond(a: str, b: str) -> Scene:
        return contact(a, b, formulation={"method": "bonded"}, form="saddle", mu=0.0, P=P)

    upwards = {"vector": [0.0, 1.0]}
    return scene(
        {
            "b0": block(0.0, 0.0, *HELD_BELOW),
            "b1": block(1.0, 0.0, *HELD_BELOW),
            "b2": block(1.0, 1.0),
            "b3": block(0.0, 1.0),
        },
        rub=contact("b0.x_max", "b1.x_min", P=P, mu=0.4, friction_direction_on_a=upwards),
        right=bond("b1.y_max", "b2.y_min"),
        top=bond("b2.x_min", "b3.x_max"),
        left=bond("b3.y_min", "b0.y_max"),
    )


def two_pads(upper: float | str, lower: float | str, joint: float) -> Scene:
    """A disc cut open, held at both ends, between a pad of two parts above and one below.

    Parameters
    ----------
    upper, lower
        Contact stiffness p (N/m^3) on either side, a number or an expression.
    joint
        Stiffness P (N/m) of the bond of lining and backplate.
    """
    ends = [{"surface": f"x_{end}"} for end in ("min", "max")]
    bond = {"formulation": {"method": "bonded"}, "mu": 0.0, "P": joint, "form": "saddle"}
    plate, below = rectangle((0.6, 0.1), (0.7, 0.2)), rectangle((0.5, 0.25), (0.9, -0.55))
    return scene(
        {
            "disc": body(rectangle((2.0, 0.3), (0.0, -0.3)), (7, 2), supports=ends),
            "lining": body(rectangle((0.6, 0.2), (0.7, 0.0)), (3, 1), E=0.05),
            "backplate": body(plate, (4, 1), E=2.0, supports=HELD_ABOVE),
            "pad": body(below, (3, 1), E=0.1, supports=HELD_BELOW),
        },
        above=contact("lining.y_min", "disc.y_max", p=upper),
        below=contact("pad.y_max", "disc.y_min", p=lower),
        joint=contact("lining.y_max", "backplate.y_min", **bond),
    )


_TWO_PADS: dict[str, tuple[float | str, float | str, float]] = {
    "both closed": (1.0, 1.0, 1e3),
    "below stiff by 1e6": (1.0, 1e6, 1e3),
    "above lifted in part": ("where(x < 0.95, 0, 3.0)", 1.0, 1e3),
    "both lifted in part, bond of 1e8": (
        "where(abs(x - 1) < 0.1, 0, 1.0)",
        "2.0*maximum(1.2 - x, 0)",
        1e8,
    ),
    "bond tied": (1.0, 1.0, inf),
    "bond weak": (1.0, 1.0, 1e-6),
}
_LIFTED = {
    "one end lifted": "where(x < 0.7, 0, {p!r})",
    "both ends lifted": "where(abs(x - 1) > 0.55, 0, {p!r})",
    "the middle lifted": "where(abs(x - 1) < 0.55, 0, {p!r})",
    "all but a corner lifted": "where(x < 1.93, 0, {p!r})",
    "p falls to zero": "{p!r}*maximum(1.1 - x, 0)",
}
"""Closed parts that end inside elements of either side."""
_SLIVERS = ("one end lifted", "all but a corner lifted")
_VARYING = {"jumps": "where(x < 1, 1.0, {ratio!r})", "grows": "exp(x/2*log({ratio!r}))"}

_PRESSURE, _E = 1000.0, 1e5
_ROUNDING = 100 * np.finfo(float).eps / _E
"""What rounding of a hundred unknowns costs a penalty for each N/m of P."""


def _pressed(P: float) -> Scene:
    """Two blocks of equal width on each other, a uniform pressure on top."""
    roller = {"surface": "x_min", "components": ["x"]}
    held = [{"surface": "y_min", "components": ["y"]}, roller]
    lower = rectangle((9.0, 4.5), (0.0, -4.5))
    data = scene(
        {
            "upper": body(rectangle((9.0, 4.5)), (3, 1), E=_E, nu=0.0, supports=[roller]),
            "lower": body(lower, (5, 1), E=_E, nu=0.0, supports=held),
        },
        contact=contact("upper.y_min", "lower.y_max", P=P, mu=0.0),
    )
    loads = [{"surface": "upper.y_max", "pressure": _PRESSURE}]
    return changed(data, {"analysis": {"kind": "static", "samples": 9}, "loads": loads})


def _patch_test(P: float) -> tuple[Rows, Rows]:
    """Exact integration passes at any P, though the upper block nearly floats at small ones."""
    rows = {f"P = {P:.0e} N/m": _pressed(P)}
    true, may = formula([-_PRESSURE]), (*MESH_AND_PENALTY, "large-displacement")
    names = ("segments", "mortar")
    lost = max(1e-5, _ROUNDING * P)
    return (
        Rows(rows, chosen(PENALTY, *names), true, tolerance=lost, warnings=may),
        Rows(rows, chosen(SADDLE, *names), true, tolerance=1e-5, warnings=may),
    )


def _floating(p: float) -> Scene:
    upper = body(rectangle((1.0, 0.5), (0.5, 0.0)), (3, 2))
    return scene(
        {"upper": upper, "lower": base((4, 2))}, contact=contact("upper.y_min", "lower.y_max", p=p)
    )


def _stiffness(P: float) -> tuple[Rows, Rows]:
    """A saddle form loses nothing; a penalty loses digits as P grows, and must say so."""
    rows, may = {f"P = {P:.0e} N/m": layers(P=P)}, MESH_AND_PENALTY
    penalty = PENALTY if P <= _HARMLESS else without(PENALTY, "lumped")
    expected = ACCURATE if P <= _HARMLESS else HONEST
    return (
        Rows(rows, penalty, expected=expected, warnings=may),
        Rows(rows, (*SADDLE, *OPEN), warnings=may),
    )


def _every_formulation(p: float) -> tuple[Rows, Rows]:
    """Mortar must be right at any stiffness; others may be wrong, and must say so."""
    rows, true = (
        {f"p = {p:.0e} N/m³": _fine_layers(p, "1.0*abs(sin(pi*x/2))")},
        _exact_layers(p, 1.0),
    )
    others = without(WAYS, "mortar")
    return (
        Rows(rows, MORTAR, true, tolerance=1e-2, warnings=MESH),
        Rows(rows, others, true, expected=HONEST, tolerance=1e-2, warnings=NONE),
    )


def _varying(ratio: float) -> tuple[Rows, Rows]:
    rows = {
        f"p {word} by {ratio:.0e}": layers(p=field.format(ratio=ratio))
        for word, field in _VARYING.items()
    }
    expected = HONEST if ratio > 1e4 else ACCURATE
    return Rows(rows, PENALTY, expected=expected, tolerance=1e-7), Rows(
        rows, SADDLE, tolerance=1e-7
    )


def _large_windows(mu: float, p: float) -> list[Rows]:
    """Systems of 11,000 unknowns, for which bounds of friction are needed.

    Those of strong friction reach too far for a search: windows say up to which growth they hold.
    """
    elements: dict[Backend, Any] = {"fe": ((22, 12), (20, 17)), "iga": ((64, 32), (60, 48))}
    row, friction = f"mu = {mu:g}, p = {p:.0e} N/m³", f"{mu}*abs(sin(pi*x/2))"
    return [
        Rows(
            {row: _fine_layers(p, friction, *sizes)},
            chosen(_MORTAR, backend=backend),
            _exact_layers(p, mu),
            expected=HONEST if mu > 1 else ACCURATE,
            tolerance=1e-3,
        )
        for backend, sizes in elements.items()
    ]


_CUBE = [1.0, 1.0, 1.0]


def _cubes(direction: Any) -> Scene:
    top, bottom = [{"surface": "z_max"}], [{"surface": "z_min"}]
    sizes = {
        "upper": (_CUBE, [0.0, 0.0, 0.0], (1, 1, 1), 1.0, top),
        "lower": (_CUBE, [0.0, 0.0, -1.0], (1, 1, 1), 1.0, bottom),
    }
    return boxes(sizes, friction_direction_on_a=direction)


_DIRECTIONS = {
    "one number in space": _cubes({"vector": [1.0]}),
    "two numbers in space": _cubes({"vector": [1.0, 0.0]}),
    "three numbers in the plane": layers(friction_direction_on_a={"vector": [1.0, 0.0, 0.0]}),
    "one number in the plane": layers(friction_direction_on_a={"vector": [1.0]}),
    "zero": layers(friction_direction_on_a={"vector": [0.0, 0.0]}),
    "normal to the contact": layers(friction_direction_on_a={"vector": [0.0, 1.0]}),
    "none": layers(friction_direction_on_a=None),
    "one expression in the plane": layers(friction_direction_on_a={"field": ["1"]}),
}

CASES = {
    "contact_stiffness": Case(
        "Contact stiffness P from 1e-6 to 1e25 N/m and infinite",
        *(rows for P in (1e-6, 1.0, 1e6, 1e10, 1e14, 1e20, 1e25) for rows in _stiffness(P)),
        Rows({"P infinite": layers(P=inf)}, (*SADDLE, *OPEN)),
    ),
    "cross_point": Case(
        "Four blocks tied round a cross point",
        Rows(
            {f"P = {P:.0e}": _four_blocks(P) for P in (1e4, 1e14, 1e20, inf)},
            chosen(SADDLE, "mortar", "GPTS, saddle"),
            lowest=6,
        ),
        Rows(
            {"P = 1e20, as at 1e14": _four_blocks(1e20)},
            chosen(SADDLE, "mortar"),
            benign,
            instead=_four_blocks(1e14),
            tolerance=1e-7,
            lowest=6,
        ),
    ),
    "directions": Case(
        "Directions of friction that are none",
        refused(_DIRECTIONS, PAIR, "friction_direction_on_a"),
        subject="what is refused",
    ),
    "formulations": Case(
        "Every formulation beside exact eigenvalues",
        *(rows for p in (1e-2, 1.0, 1e2, 1e4) for rows in _every_formulation(p)),
    ),
    "lift_off": Case(
        "Contact that has lifted off in part: p is zero there",
        *(
            Rows(
                {f"{zone}, p to {p:.0e}": layers(p=_LIFTED[zone].format(p=p)) for zone in zones},
                tolerance=1e-7,
            )
            for p, zones in ((1.0, tuple(_LIFTED)), (1e4, _SLIVERS))
        ),
        refused({"lifted everywhere": layers(p="0*x"), "negative": layers(p="x - 0.5")}, names="p"),
    ),
    "mortar": Case(
        "Mortar beside exact eigenvalues, p from 1e-2 N/m³ to infinity",
        *(
            Rows(
                {f"blocks, p = {p:.0e} N/m³": _fine_layers(p, "0.3*abs(sin(pi*x/2))")},
                _MORTAR,
                _exact_layers(p, 0.3),
                tolerance=1e-3,
            )
            for p in (1e-2, 1.0, 1e3, 1e6, 1e9, 1e12, inf)
        ),
        *(
            Rows(
                {f"drum, p = {p:.0e} N/m³": _drum(p)},
                _MORTAR,
                exact("drum", max_frequency=0.33, p="inf" if p == inf else p, mu="0.3"),
                tolerance=1e-3,
            )
            for p in (1e-2, 1.0, 1e3, 1e6, 1e9, 1e12, inf)
        ),
    ),
    "nearly_floating": Case(
        "A block held by a contact of p = 1e-2 to 1e-12 N/m³",
        *(
            Rows({f"p = {p:.0e} N/m³": _floating(p)}, FEW, tolerance=1e-7, warnings=may)
            for p, may in ((1e-2, MESH), (1e-6, MESH), (1e-12, (*MESH, "undecided")))
        ),
    ),
    "patch_test": Case(
        "Contact patch test at P from 1e-4 to 1e16 and infinite",
        *(rows for P in (1e-4, 1.0, 1e3, 1e6, 1e10, 1e14, 1e16) for rows in _patch_test(P)),
        Rows(
            {"P infinite": _pressed(inf)},
            chosen(MORTAR, "mortar, saddle"),
            formula([-_PRESSURE]),
            tolerance=1e-5,
        ),
    ),
    "stiff_windows": Case(
        "Stiff contact in systems of 11,000 unknowns",
        *(rows for mu in (0.3, 1.5) for p in (1e3, 1e9, inf) for rows in _large_windows(mu, p)),
    ),
    "two_pads": Case(
        "Two pads on a disc, a lining bonded to its backplate",
        Rows(
            {row: two_pads(*stiffnesses) for row, stiffnesses in _TWO_PADS.items()},
            tolerance=1e-7,
            warnings=MESH_AND_PENALTY,
        ),
        subject="several contacts",
    ),
    "unequal_sides": Case(
        "Full pass with p over sides of unequal area",
        Rows({f"p = {p:.0e} N/m³": pad(p=p) for p in (1.0, 1e4)}, chosen(WAYS, "GPTS, full pass")),
        Rows({"p infinite": pad(p=inf)}, chosen(WAYS, "GPTS, full pass, saddle")),
    ),
    "varying_stiffness": Case(
        "Contact stiffness p that varies by 1e4 to 1e15",
        *(rows for ratio in (1e4, 1e8, 1e12, 1e15) for rows in _varying(ratio)),
    ),
}
