"""Cases of contact: stiffness from near zero to infinite, partly open and several contacts."""

from functools import partial
from math import inf
from typing import Any

import numpy as np
from scipy.linalg import eigvals

from comparisons.stability.case import Reference, Runs, exact, formula, refused, runs
from comparisons.stability.dense import lambdas
from comparisons.stability.problems import of_mesh_file
from comparisons.stability.scenes import (
    FINE,
    Scene,
    base,
    body,
    boxes,
    changed,
    coarse,
    contact,
    layers,
    pad,
    patch,
    rectangle,
    scene,
    stacked,
    up_to,
)
from comparisons.stability.ways import FEW, MORTAR, OPEN, PAIR, PENALTY, SADDLE, WAYS, chosen

_HARMLESS = 1e6  # P up to which a penalty loses no digits, and lumping has a reference
_MORTAR, _PENALTY = chosen(SADDLE, "mortar"), ("penalty-rounding",)


def contact_stiffness() -> Runs:
    """Contact stiffness P from 1e-6 to 1e25 N/m and infinite."""
    for P in (1e-6, 1.0, 1e6, 1e10, 1e14, 1e20, 1e25):
        # A saddle form loses no digits; a penalty loses digits as P grows, and must warn.
        harmless, rows = P <= _HARMLESS, {f"P = {P:.0e} N/m": layers(P=P)}
        penalty = PENALTY if harmless else chosen(PENALTY, without="lumped")
        expected = "accurate" if harmless else "honest"
        yield from runs(rows, penalty, expected=expected, also=_PENALTY)
        yield from runs(rows, (*SADDLE, *OPEN), also=_PENALTY)
    yield from runs({"P infinite": layers(P=inf)}, (*SADDLE, *OPEN))


def varying_stiffness() -> Runs:
    """Contact stiffness p that varies by 1e4 to 1e15."""
    for ratio in (1e4, 1e8, 1e12, 1e15):
        rows = {
            f"p jumps by {ratio:.0e}": layers(p=f"where(x < 1, 1.0, {ratio!r})"),
            f"p grows by {ratio:.0e}": layers(p=f"exp(x/2*log({ratio!r}))"),
        }
        expected = "honest" if ratio > 1e4 else "accurate"
        yield from runs(rows, PENALTY, expected=expected, tolerance=1e-7)
        yield from runs(rows, SADDLE, tolerance=1e-7)


def _bond(a: str, b: str, P: float) -> Scene:
    return contact(a, b, formulation={"method": "bonded"}, form="saddle", mu=0.0, P=P)


def _four_blocks(P: float) -> Scene:
    """Two blocks that slide on each other, two bonded on top of them and to each other."""

    def block(x: float, y: float, held: str = "") -> Scene:
        return body(rectangle((1.0, 1.0), (x, y)), (4, 4), held=held)

    upwards = {"vector": [0.0, 1.0]}
    return scene(
        {
            "b0": block(0.0, 0.0, "y_min"),
            "b1": block(1.0, 0.0, "y_min"),
            "b2": block(1.0, 1.0),
            "b3": block(0.0, 1.0),
        },
        rub=contact("b0.x_max", "b1.x_min", P=P, mu=0.4, friction_direction_on_a=upwards),
        right=_bond("b1.y_max", "b2.y_min", P),
        top=_bond("b2.x_min", "b3.x_max", P),
        left=_bond("b3.y_min", "b0.y_max", P),
    )


def cross_point() -> Runs:
    """Four blocks tied around a cross point."""
    for P in (1e4, 1e14, 1e20, inf):
        ways = chosen(SADDLE, "mortar", "GPTS, saddle")
        yield from runs({f"P = {P:.0e}": _four_blocks(P)}, ways, lowest=6)
    stiff, less = {"P = 1e20, as at 1e14": _four_blocks(1e20)}, _four_blocks(1e14)
    yield from runs(stiff, _MORTAR, instead=less, tolerance=1e-7, lowest=6)


def _two_pads(upper: float | str, lower: float | str, joint: float) -> Scene:
    """A straight disc between a pad of two parts above and one below; p of both, P of the joint."""
    ends = [{"surface": f"x_{end}"} for end in ("min", "max")]
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
        joint=_bond("lining.y_max", "backplate.y_min", joint),
    )


def two_pads() -> Runs:
    """Two pads on a disc, a lining bonded to its backplate."""
    lifted, falling = "where(abs(x - 1) < 0.1, 0, 1.0)", "2.0*maximum(1.2 - x, 0)"
    rows = {
        "both closed": _two_pads(1.0, 1.0, 1e3),
        "below stiff by 1e6": _two_pads(1.0, 1e6, 1e3),
        "above lifted in part": _two_pads("where(x < 0.95, 0, 3.0)", 1.0, 1e3),
        "both lifted in part, bond of 1e8": _two_pads(lifted, falling, 1e8),
        "bond tied": _two_pads(1.0, 1.0, inf),
        "bond weak": _two_pads(1.0, 1.0, 1e-6),
    }
    return runs(rows, tolerance=1e-7, also=_PENALTY)


def lift_off() -> Runs:
    """Contact that has lifted off in part: p is zero there."""
    rows = {  # closed parts end inside elements of either side
        "one end lifted, p to 1e+00": layers(p="where(x < 0.7, 0, 1.0)"),
        "both ends lifted, p to 1e+00": layers(p="where(abs(x - 1) > 0.55, 0, 1.0)"),
        "the middle lifted, p to 1e+00": layers(p="where(abs(x - 1) < 0.55, 0, 1.0)"),
        "all but a corner lifted, p to 1e+00": layers(p="where(x < 1.93, 0, 1.0)"),
        "p falls to zero, p to 1e+00": layers(p="1.0*maximum(1.1 - x, 0)"),
        "one end lifted, p to 1e+04": layers(p="where(x < 0.7, 0, 10000.0)"),
        "all but a corner lifted, p to 1e+04": layers(p="where(x < 1.93, 0, 10000.0)"),
    }
    yield from runs(rows, tolerance=1e-7)
    open_ = {"lifted everywhere": layers(p="0*x"), "negative": layers(p="x - 0.5")}
    yield from refused(open_, names="p")


def nearly_floating() -> Runs:
    """A block held by a contact of p = 1e-2 to 1e-12 N/m³."""
    block = body(rectangle((1.0, 0.5), (0.5, 0.0)), (3, 2))
    for p in (1e-2, 1e-6, 1e-12):
        rows = {f"p = {p:.0e} N/m³": stacked(block, base((4, 2)), p=p)}
        also = ("undecided",) if p == 1e-12 else ()
        yield from runs(rows, FEW, tolerance=1e-7, also=also)


def patch_test() -> Runs:
    """Contact patch test at P from 1e-4 to 1e16 and infinite."""
    # Exact integration passes at any P, though the upper block nearly floats at small ones.
    E, pressure, may = 1e5, 1000.0, (*_PENALTY, "large-displacement")
    rounding = 100 * np.finfo(float).eps / E  # rounding of 100 unknowns per N/m of a penalty
    roller: Scene = {"surface": "x_min", "components": ["x"]}
    held = [{"surface": "y_min", "components": ["y"]}, roller]
    above, below = rectangle((9.0, 4.5)), rectangle((9.0, 4.5), (0.0, -4.5))
    upper = body(above, (3, 1), E=E, nu=0.0, supports=[roller])
    lower = body(below, (5, 1), E=E, nu=0.0, supports=held)

    def pressed(P: float) -> Scene:
        loads = [{"surface": "upper.y_max", "pressure": pressure}]
        fields = {"loads": loads, "analysis.samples": 9}
        return changed(stacked(upper, lower, "static", P=P, mu=0.0), fields)

    true = formula([-pressure])
    for P in (1e-4, 1.0, 1e3, 1e6, 1e10, 1e14, 1e16):
        for ways, lost in ((PENALTY, max(1e-5, rounding * P)), (SADDLE, 1e-5)):
            exactly, rows = chosen(ways, "segments", "mortar"), {f"P = {P:.0e} N/m": pressed(P)}
            yield from runs(rows, exactly, true, tolerance=lost, also=may)
    yield from runs({"P infinite": pressed(inf)}, _MORTAR, true, tolerance=1e-5)


def unequal_sides() -> Runs:
    """Full pass with p over sides of unequal area."""
    for p in (1.0, 1e4):
        yield from runs({f"p = {p:.0e} N/m³": pad(p=p)}, chosen(WAYS, "GPTS, full pass"))
    yield from runs({"p infinite": pad(p=inf)}, chosen(SADDLE, "GPTS, full pass"))


def _cubic_layers(p: float, mu: str, **elements: Any) -> Scene:
    """Layers for which exact eigenvalues are known."""
    return up_to(0.42, layers(both={"degree": 3}, p=p, mu=mu, **FINE | elements))


def _exact_layers(p: float, mu: float) -> Reference:
    return exact("blocks", max_frequency=0.42, p="inf" if p == inf else p, mu=str(mu))


def _drum(p: float) -> Scene:
    drum = coarse("drum", 3, outer=(2, 20), inner=(2, 16))
    return up_to(0.33, changed(drum, {"contacts.interface.p": p}))


def formulations() -> Runs:
    """Every formulation against exact eigenvalues."""
    for p in (1e-2, 1.0, 1e2, 1e4):
        # Mortar must be accurate at any stiffness; others may be inaccurate, but must warn.
        rows = {f"p = {p:.0e} N/m³": _cubic_layers(p, "1.0*abs(sin(pi*x/2))")}
        ways, true = chosen(WAYS, without="mortar"), _exact_layers(p, 1.0)
        yield from runs(rows, MORTAR, true, tolerance=1e-2)
        yield from runs(rows, ways, true, expected="honest", tolerance=1e-2, warnings=())


def mortar() -> Runs:
    """Mortar against exact eigenvalues, p from 1e-2 N/m³ to infinity."""
    stiffnesses = (1e-2, 1.0, 1e3, 1e6, 1e9, 1e12, inf)
    for p in stiffnesses:
        rows = {f"blocks, p = {p:.0e} N/m³": _cubic_layers(p, "0.3*abs(sin(pi*x/2))")}
        yield from runs(rows, _MORTAR, _exact_layers(p, 0.3), tolerance=1e-3)
    for p in stiffnesses:
        true = exact("drum", max_frequency=0.33, p="inf" if p == inf else p, mu="0.3")
        rows = {f"drum, p = {p:.0e} N/m³": _drum(p)}
        for backend in ("fe", "iga"):  # finite elements have more than 1,000 unknowns
            expected = "warned" if backend == "fe" and p > 1 else "accurate"
            ways = chosen(_MORTAR, backend=backend)
            yield from runs(rows, ways, true, expected=expected, tolerance=1e-3)


def stiff_windows() -> Runs:
    """Stiff contact in systems of 11,000 unknowns."""
    # No bound on the effect of friction holds here: windows state the growth that they cover.
    elements = {
        "fe": {"upper_elements": (22, 12), "lower_elements": (20, 17)},
        "iga": {"upper_elements": (64, 32), "lower_elements": (60, 48)},
    }
    for mu in (0.3, 1.5):
        for p in (1e3, 1e9, inf):
            row, friction = f"mu = {mu:g}, p = {p:.0e} N/m³", f"{mu}*abs(sin(pi*x/2))"
            true = _exact_layers(p, mu)
            for backend, sizes in elements.items():
                rows = {row: _cubic_layers(p, friction, **sizes)}
                way = chosen(_MORTAR, backend=backend)
                yield from runs(rows, way, true, expected="warned", tolerance=1e-3)


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
        yield from refused({row: data}, PAIR, "friction_direction_on_a")


def _quadrilateral(x: float, y: float, right: float, top: float) -> Scene:
    """A rectangle as a patch, between two corners."""
    return patch([[x, y], [right, y]], [[x, top], [right, top]])


def _corner(p: float, *, together: bool = True, E: float = 1.0) -> Scene:
    """A block in the corner of a seat, one contact over both faces or one for each."""
    block, seat = _quadrilateral(0.0, 0.0, 1.0, 1.0), _quadrilateral(-0.5, -0.5, 0.0, 0.0)
    below, left = [[0, 1, 0]], [[0, 0, 0]]
    block["faces"] = {"below": below, "left": left, "corner": below + left}
    for part in (_quadrilateral(0.0, -0.5, 1.5, 0.0), _quadrilateral(-0.5, 0.0, 0.0, 1.5)):
        seat["patches"] += part["patches"]
    floor, wall, foot = [[1, 1, 1]], [[2, 0, 1]], [[0, 1, 0], [1, 1, 0]]
    seat["faces"] = {"base": foot, "floor": floor, "wall": wall, "corner": floor + wall}
    bodies = {"block": body(block, (4, 4), E=E), "seat": body(seat, (3, 3), E=E, held="base")}
    contacts = {
        "floor": _push("block.below", "seat.floor", [1.0, 0.0], p),
        "wall": _push("block.left", "seat.wall", [0.0, 1.0], p),
    }
    if together:
        contacts = {"contact": _push("block.corner", "seat.corner", [1.0, 1.0], p)}
    return scene(bodies, **contacts)


def _push(a: str, b: str, direction: list[float], p: float) -> Scene:
    return contact(a, b, p=p, friction_direction_on_a={"vector": direction})


def contact_corner() -> Runs:
    """A contact whose surfaces turn a corner."""
    rigid, mu = 1e7, 0.3  # E beside a contact of p = 1 N/m³
    bodies = {
        "block": body(rectangle((1.0, 1.0)), (4, 4), E=rigid),
        "seat": body(rectangle((2.0, 2.0), (-0.5, -0.5)), (8, 8), E=rigid, held="y_min"),
    }
    of_file = scene(bodies, contact=_push("block.corner", "seat.corner", [1.0, 1.0], 1.0))
    # Motions of a rigid block along x, along y and about the corner: on a face the gap is n.u, the
    # slip k.u, and its pressure and friction are p (n - mu k) n.u (k the direction of friction).
    K = [[1.0, mu, (mu - 1) / 2], [mu, 1.0, (1 - mu) / 2], [-0.5, 0.5, 2 / 3]]
    M = [[1.0, 0.0, -0.5], [0.0, 1.0, 0.5], [-0.5, 0.5, 2 / 3]]
    true = formula(lambdas(eigvals(K, M)))
    ways = chosen(WAYS, "segments", "mortar", "GPTS, penalty", "GPTS, saddle")
    fe, iga = (chosen(ways, backend=backend) for backend in ("fe", "iga"))
    rows, seat = {"rigid bodies": up_to(1.0, of_file)}, partial(of_mesh_file, notched="seat")
    yield from runs(rows, fe, true, problem=seat, tolerance=1e-6)
    rows = {"rigid bodies": up_to(1.0, _corner(1.0, E=rigid))}
    yield from runs(rows, iga, true, tolerance=1e-6)
    for row, p, some in (
        ("as a contact for each face", 1.0, chosen(WAYS, backend="iga")),
        ("tied, as a tie for each face", inf, chosen(SADDLE, "mortar", backend="iga")),
    ):
        yield from runs({row: _corner(p)}, some, instead=_corner(p, together=False))
