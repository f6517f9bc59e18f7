"""Cases of contact: stiffness from near zero to infinite, partly open and several contacts."""

from math import inf
from typing import Any

import numpy as np

from comparisons.stability.case import Reference, Runs, exact, formula, refused, runs
from comparisons.stability.scenes import (
    ABOUT_Z,
    Scene,
    base,
    body,
    boxes,
    contact,
    layers,
    pad,
    rectangle,
    ring,
    scene,
    up_to,
)
from comparisons.stability.ways import FEW, MORTAR, OPEN, PAIR, PENALTY, SADDLE, WAYS, chosen

_HARMLESS = 1e6  # P up to which a penalty loses no digits, and lumping has a reference
_MORTAR, _PENALTY = chosen(SADDLE, "mortar"), ("penalty-rounding",)


def contact_stiffness() -> Runs:
    """Contact stiffness P from 1e-6 to 1e25 N/m and infinite."""
    for P in (1e-6, 1.0, 1e6, 1e10, 1e14, 1e20, 1e25):
        # A saddle form loses no digits; a penalty loses digits as P grows, and must warn.
        harmless, data, row = P <= _HARMLESS, layers(P=P), f"P = {P:.0e} N/m"
        penalty = PENALTY if harmless else chosen(PENALTY, without="lumped")
        expected = "accurate" if harmless else "honest"
        yield from runs(row, data, penalty, expected=expected, also=_PENALTY)
        yield from runs(row, data, (*SADDLE, *OPEN), also=_PENALTY)
    yield from runs("P infinite", layers(P=inf), (*SADDLE, *OPEN))


def varying_stiffness() -> Runs:
    """Contact stiffness p that varies by 1e4 to 1e15."""
    for ratio in (1e4, 1e8, 1e12, 1e15):
        jumps, grows = f"where(x < 1, 1.0, {ratio!r})", f"exp(x/2*log({ratio!r}))"
        fields: dict[str, str] = {
            f"p jumps by {ratio:.0e}": jumps,
            f"p grows by {ratio:.0e}": grows,
        }
        for ways in (PENALTY, SADDLE):
            expected = "honest" if ratio > 1e4 and ways == PENALTY else "accurate"
            for row, p in fields.items():
                yield from runs(row, layers(p=p), ways, expected=expected, tolerance=1e-7)


def _four_blocks(P: float) -> Scene:
    """Two blocks that slide on each other, two bonded on top of them and to each other."""

    def block(x: float, y: float, held: str = "") -> Scene:
        return body(rectangle((1.0, 1.0), (x, y)), (4, 4), held=held)

    def bond(a: str, b: str) -> Scene:
        return contact(a, b, formulation={"method": "bonded"}, form="saddle", mu=0.0, P=P)

    upwards = {"vector": [0.0, 1.0]}
    return scene(
        {
            "b0": block(0.0, 0.0, "y_min"),
            "b1": block(1.0, 0.0, "y_min"),
            "b2": block(1.0, 1.0),
            "b3": block(0.0, 1.0),
        },
        rub=contact("b0.x_max", "b1.x_min", P=P, mu=0.4, friction_direction_on_a=upwards),
        right=bond("b1.y_max", "b2.y_min"),
        top=bond("b2.x_min", "b3.x_max"),
        left=bond("b3.y_min", "b0.y_max"),
    )


def cross_point() -> Runs:
    """Four blocks tied around a cross point."""
    for P in (1e4, 1e14, 1e20, inf):
        ways = chosen(SADDLE, "mortar", "GPTS, saddle")
        yield from runs(f"P = {P:.0e}", _four_blocks(P), ways, lowest=6)
    stiff, less = _four_blocks(1e20), _four_blocks(1e14)
    yield from runs("P = 1e20, as at 1e14", stiff, _MORTAR, instead=less, tolerance=1e-7, lowest=6)


def _two_pads(upper: float | str, lower: float | str, joint: float) -> Scene:
    """A straight disc between a pad of two parts above and one below; p of both, P of the joint."""
    ends = [{"surface": f"x_{end}"} for end in ("min", "max")]
    bond = {"formulation": {"method": "bonded"}, "mu": 0.0, "P": joint, "form": "saddle"}
    plate, below = rectangle((0.6, 0.1), (0.7, 0.2)), rectangle((0.5, 0.25), (0.9, -0.55))
    return scene(
        {
            "disc": body(rectangle((2.0, 0.3), (0.0, -0.3)), (7, 2), supports=ends),
            "lining": body(rectangle((0.6, 0.2), (0.7, 0.0)), (3, 1), E=0.05),
            "backplate": body(plate, (4, 1), E=2.0, held="y_max"),
            "pad": body(below, (3, 1), E=0.1, held="y_min"),
        },
        above=contact("lining.y_min", "disc.y_max", p=upper),
        below=contact("pad.y_max", "disc.y_min", p=lower),
        joint=contact("lining.y_max", "backplate.y_min", **bond),
    )


def two_pads() -> Runs:
    """Two pads on a disc, a lining bonded to its backplate."""
    lifted, falling = "where(abs(x - 1) < 0.1, 0, 1.0)", "2.0*maximum(1.2 - x, 0)"
    for row, data in {
        "both closed": _two_pads(1.0, 1.0, 1e3),
        "below stiff by 1e6": _two_pads(1.0, 1e6, 1e3),
        "above lifted in part": _two_pads("where(x < 0.95, 0, 3.0)", 1.0, 1e3),
        "both lifted in part, bond of 1e8": _two_pads(lifted, falling, 1e8),
        "bond tied": _two_pads(1.0, 1.0, inf),
        "bond weak": _two_pads(1.0, 1.0, 1e-6),
    }.items():
        yield from runs(row, data, tolerance=1e-7, also=_PENALTY)


def lift_off() -> Runs:
    """Contact that has lifted off in part: p is zero there."""
    for zone, p in (  # closed parts end inside elements of either side
        ("one end lifted, p to 1e+00", "where(x < 0.7, 0, 1.0)"),
        ("both ends lifted, p to 1e+00", "where(abs(x - 1) > 0.55, 0, 1.0)"),
        ("the middle lifted, p to 1e+00", "where(abs(x - 1) < 0.55, 0, 1.0)"),
        ("all but a corner lifted, p to 1e+00", "where(x < 1.93, 0, 1.0)"),
        ("p falls to zero, p to 1e+00", "1.0*maximum(1.1 - x, 0)"),
        ("one end lifted, p to 1e+04", "where(x < 0.7, 0, 10000.0)"),
        ("all but a corner lifted, p to 1e+04", "where(x < 1.93, 0, 10000.0)"),
    ):
        yield from runs(zone, layers(p=p), tolerance=1e-7)
    yield from refused("lifted everywhere", layers(p="0*x"), names="p")
    yield from refused("negative", layers(p="x - 0.5"), names="p")


def nearly_floating() -> Runs:
    """A block held by a contact of p = 1e-2 to 1e-12 N/m³."""
    block = body(rectangle((1.0, 0.5), (0.5, 0.0)), (3, 2))
    for p in (1e-2, 1e-6, 1e-12):
        held = contact("upper.y_min", "lower.y_max", p=p)
        data = scene({"upper": block, "lower": base((4, 2))}, contact=held)
        also = ("undecided",) if p == 1e-12 else ()
        yield from runs(f"p = {p:.0e} N/m³", data, FEW, tolerance=1e-7, also=also)


def patch_test() -> Runs:
    """Contact patch test at P from 1e-4 to 1e16 and infinite."""
    # Exact integration passes at any P, though the upper block nearly floats at small ones.
    E, pressure, may = 1e5, 1000.0, (*_PENALTY, "large-displacement")
    rounding = 100 * np.finfo(float).eps / E  # rounding of 100 unknowns per N/m of a penalty
    roller: Scene = {"surface": "x_min", "components": ["x"]}
    held = [{"surface": "y_min", "components": ["y"]}, roller]
    upper, lower = rectangle((9.0, 4.5)), rectangle((9.0, 4.5), (0.0, -4.5))
    bodies = {
        "upper": body(upper, (3, 1), E=E, nu=0.0, supports=[roller]),
        "lower": body(lower, (5, 1), E=E, nu=0.0, supports=held),
    }

    def pressed(P: float) -> Scene:
        sliding = contact("upper.y_min", "lower.y_max", P=P, mu=0.0)
        data = scene(bodies, {"kind": "static", "samples": 9}, contact=sliding)
        return data | {"loads": [{"surface": "upper.y_max", "pressure": pressure}]}

    true = formula([-pressure])
    for P in (1e-4, 1.0, 1e3, 1e6, 1e10, 1e14, 1e16):
        for ways, lost in ((PENALTY, max(1e-5, rounding * P)), (SADDLE, 1e-5)):
            exactly, row = chosen(ways, "segments", "mortar"), f"P = {P:.0e} N/m"
            yield from runs(row, pressed(P), exactly, true, tolerance=lost, also=may)
    yield from runs("P infinite", pressed(inf), _MORTAR, true, tolerance=1e-5)


def unequal_sides() -> Runs:
    """Full pass with p over sides of unequal area."""
    for p in (1.0, 1e4):
        yield from runs(f"p = {p:.0e} N/m³", pad(p=p), chosen(WAYS, "GPTS, full pass"))
    yield from runs("p infinite", pad(p=inf), chosen(SADDLE, "GPTS, full pass"))


def _cubic_layers(p: float, mu: str, upper: Any = (8, 3), lower: Any = (7, 4)) -> Scene:
    """Layers for which exact eigenvalues are known."""
    cubic = {"degree": 3}
    data = layers(upper=cubic, lower=cubic, upper_elements=upper, lower_elements=lower, p=p, mu=mu)
    return up_to(0.42, data)


def _exact_layers(p: float, mu: float) -> Reference:
    return exact("blocks", max_frequency=0.42, p="inf" if p == inf else p, mu=str(mu))


def _drum(p: float) -> Scene:
    soft: Scene = {"E": 0.1, "nu": 0.25, "rho": 0.35, "held": "outer"}
    bodies = {
        "outer": body(ring(1.0, 1.5), (2, 20), degree=3, **soft),
        "inner": body(ring(0.5, 1.0), (2, 16), degree=3, held="inner"),
    }
    sliding = contact("outer.inner", "inner.outer", p=p, friction_direction_on_a=ABOUT_Z)
    return up_to(0.33, scene(bodies, interface=sliding))


def formulations() -> Runs:
    """Every formulation against exact eigenvalues."""
    for p in (1e-2, 1.0, 1e2, 1e4):
        # Mortar must be accurate at any stiffness; others may be inaccurate, but must warn.
        row, true = f"p = {p:.0e} N/m³", _exact_layers(p, 1.0)
        data = _cubic_layers(p, "1.0*abs(sin(pi*x/2))")
        yield from runs(row, data, MORTAR, true, tolerance=1e-2)
        ways, fields = chosen(WAYS, without="mortar"), dict[str, Any](tolerance=1e-2, warnings=())
        yield from runs(row, data, ways, true, expected="honest", **fields)


def mortar() -> Runs:
    """Mortar against exact eigenvalues, p from 1e-2 N/m³ to infinity."""
    stiffnesses = (1e-2, 1.0, 1e3, 1e6, 1e9, 1e12, inf)
    for p in stiffnesses:
        row, data = f"blocks, p = {p:.0e} N/m³", _cubic_layers(p, "0.3*abs(sin(pi*x/2))")
        yield from runs(row, data, _MORTAR, _exact_layers(p, 0.3), tolerance=1e-3)
    for p in stiffnesses:
        true = exact("drum", max_frequency=0.33, p="inf" if p == inf else p, mu="0.3")
        row, data = f"drum, p = {p:.0e} N/m³", _drum(p)
        for backend in ("fe", "iga"):  # finite elements have more than 1,000 unknowns
            expected = "warned" if backend == "fe" and p > 1 else "accurate"
            ways = chosen(_MORTAR, backend=backend)
            yield from runs(row, data, ways, true, expected=expected, tolerance=1e-3)


def stiff_windows() -> Runs:
    """Stiff contact in systems of 11,000 unknowns."""
    # No bound on the effect of friction holds here: windows state the growth that they cover.
    elements = {"fe": ((22, 12), (20, 17)), "iga": ((64, 32), (60, 48))}
    for mu in (0.3, 1.5):
        for p in (1e3, 1e9, inf):
            row, friction = f"mu = {mu:g}, p = {p:.0e} N/m³", f"{mu}*abs(sin(pi*x/2))"
            for backend, sizes in elements.items():
                data, way = _cubic_layers(p, friction, *sizes), chosen(_MORTAR, backend=backend)
                true = _exact_layers(p, mu)
                yield from runs(row, data, way, true, expected="warned", tolerance=1e-3)


def directions() -> Runs:
    """Invalid directions of friction."""
    cube = (1.0, 1.0, 1.0), (1, 1, 1)
    for row, direction in (
        ("one number in space", {"vector": [1.0]}),
        ("two numbers in space", {"vector": [1.0, 0.0]}),
        ("three numbers in the plane", {"vector": [1.0, 0.0, 0.0]}),
        ("one number in the plane", {"vector": [1.0]}),
        ("zero", {"vector": [0.0, 0.0]}),
        ("normal to the contact", {"vector": [0.0, 1.0]}),
        ("none", None),
        ("one expression in the plane", {"field": ["1"]}),
    ):
        field: dict[str, Any] = {"friction_direction_on_a": direction}
        data = boxes(cube, cube, **field) if row.endswith("space") else layers(**field)
        yield from refused(row, data, PAIR, "friction_direction_on_a")
