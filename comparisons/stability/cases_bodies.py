"""Cases of bodies: extreme geometry, materials and units, degrees and shapes of elements."""

from functools import partial
from typing import Any

import numpy as np

from comparisons.stability.case import Runs, exact, formula, refused, runs
from comparisons.stability.problems import of_mesh_file
from comparisons.stability.scenes import (
    ABOUT_Z,
    FINE,
    LINING,
    STEEL,
    Scene,
    body,
    boxes,
    changed,
    contact,
    in_units,
    layers,
    moved,
    on_base,
    pad,
    patch,
    rectangle,
    ring,
    scene,
    spline_patch,
    stacked,
    up_to,
)
from comparisons.stability.ways import ALONE, FEW, MORTAR, PAIR, SADDLE, WAYS, chosen

_FE, _IGA = chosen(PAIR, backend="fe"), chosen(WAYS, backend="iga")
_PART = chosen(WAYS, "node", "Greville", "GPTS, penalty", "segments, penalty", "mortar")
_FRICTION = "0.3*abs(sin(pi*x/2))"


def apart() -> Runs:
    """Sides of a contact 0.1 to 0.24 m apart."""
    for distance in (0.1, 0.24):
        data = changed(pad(1.0), {"bodies.pad.geometry.origin": [0.5, distance]})
        away, rows = data | {"contacts": {}}, {f"{distance:g} m apart": data}  # no side touches
        yield from runs(rows, _PART, instead=away, expected="not accurate")


def aspect() -> Runs:
    """Elements 1e3 times longer than wide, both ways."""
    for row, width, height, expected, tolerance in (
        ("flat elements", 1e3, 1.0, "accurate", 1e-8),
        ("columns", 1.0, 1e3, "warned", 1e-4),
    ):
        above = body(rectangle((width, height)), (2, 2), E=0.5, held="y_max")
        below = body(rectangle((width, height), (0.0, -height)), (3, 2), held="y_min")
        yield from runs({row: stacked(above, below)}, FEW, expected=expected, tolerance=tolerance)


def contact_edges() -> Runs:
    """Edges of the contact inside elements, contact on one element."""
    rows = {  # element boundaries of the base: 0.4, 0.8
        "edges inside elements": pad(0.5, 0.63),
        "on one element": pad(0.1, 0.85),
        "one element on one": pad(0.1, 0.85, pad_elements=(1, 1)),
        "edge on an edge": pad(0.4, 0.8, pad_elements=(2, 2)),
        "edge almost on an edge": pad(0.4, 0.8 - 1e-13, pad_elements=(2, 2)),
    }
    return runs(rows, chosen(WAYS, without="full pass"))


def crowned() -> Runs:
    """A crowned face, its radius of curvature from 0.05 to 1e30."""
    flat, ways = pad(0.5), chosen(_PART, without="mortar, saddle")

    def made(radius: float) -> Scene:
        base = flat["bodies"]["pad"]["geometry"]
        face = {"base": base, "surface": "y_min", "radii": {"x": radius}}
        return changed(flat, {"bodies.pad.geometry": {"shape": "crowned", **face}})

    for radius in (1e4, 1e6, 1e8, 1e12, 1e30):
        fall = 0.5**2 / (8 * radius) / 0.4  # of the face, relative to the height of the pad
        tolerance = max(1e-8, 10 * fall if fall > 1e-10 else 0.0)
        yield from runs({f"radius {radius:.0e}": made(radius)}, instead=flat, tolerance=tolerance)
    leaves = changed(made(0.5), {"contacts.contact.reach": 0.3})  # the side of the pad
    away = leaves | {"contacts": {}}
    yield from runs({"radius 0.5, closed": leaves}, ways, instead=away, expected="not accurate")
    yield from refused({"radius 0.05": made(0.05)}, ways, "radii")


def edge_layers() -> Runs:
    """Layers of cells towards edges."""

    def crowded(number: int, **options: Any) -> Scene:
        edges = [{"x": 0.0, "y": -1.0}, {"x": 2.0, "y": 0.0}]  # of the foot, and of the contact
        data = layers(**options)
        data["bodies"]["lower"]["mesh"]["fe"].update({"edges": edges, "layers": number})
        return data

    for degree in (1, 2, 4):
        for n in (1, 4, 8):
            row = f"{n} layer{'s' if n > 1 else ''}, degree {degree}"
            yield from runs({row: crowded(n, lower={"degree": degree})}, _FE)
    one_cell = crowded(1, lower_elements=(1, 1))
    yield from refused({"edges at opposite corners of a cell": one_cell}, _FE, "elements")


def far_origin() -> Runs:
    """The origin 1e3 and 1e6 m away."""
    for away, tolerance in ((1e3, 1e-9), (1e6, 1e-6)):
        for name, data in (("layers", layers()), ("pad", pad(max_missed=0.6))):
            rows = {f"{name} {away:.0e} m away": moved(data, (away, -away))}
            yield from runs(rows, instead=data, tolerance=tolerance)


def mesh_ratio() -> Runs:
    """Mesh ratio 1 to 50 across the contact, both ways."""
    for row, upper, lower in (("1 element on 50", 1, 50), ("50 elements on 1", 50, 1)):
        yield from runs({row: layers(upper_elements=(upper, 1), lower_elements=(lower, 1))})


def narrow_sector() -> Runs:
    """Sectors of 90 to 0.1 degrees."""
    for degrees in (90.0, 1.0, 0.1):
        angles = {"shape": "ring_sector", "start": 30.0, "end": 30.0 + degrees}
        bodies = {
            "outer": body(ring(1.0, 1.5) | angles, (2, 3), held="outer"),
            "inner": body(ring(0.5, 1.0) | angles, (2, 2), held="inner"),
        }
        sliding = contact("outer.inner", "inner.outer", friction_direction_on_a=ABOUT_Z)
        may: dict[str, Any] = {"expected": "warned", "tolerance": 1e-6} if degrees < 1 else {}
        yield from runs({f"{degrees:g} degrees": scene(bodies, contact=sliding)}, FEW, **may)


def overhang() -> Runs:
    """A pad over the edge of its base."""
    names = "node", "Greville", "GPTS", "segments", "mortar"
    ways = chosen(WAYS, *names, without="full pass")
    yield from refused({"half of it, not allowed": pad(0.5, 1.75)}, ways, "contact")
    allowed = {"half of it, allowed": pad(0.5, 1.75, max_missed=0.6)}
    yield from runs(allowed, ways, also=("partly-uncovered",))


def thin_layer() -> Runs:
    """A layer in contact, thickness 1e-3 to 1e-5 of its length."""
    for height in (2e-3, 2e-4, 2e-5):
        rows = {f"thickness {height / 2:.0e} of the length": layers(height=height)}
        yield from runs(rows, FEW, tolerance=1e-7)


_BENDING = np.array([1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349, 14.1371683910])
"""beta L of a cantilever: cos x cosh x = -1."""


def thin_strip() -> Runs:
    """Thin cantilevers, length over height 100 to 1e5."""
    for slenderness in (1e2, 1e3, 2e4, 1e5):
        # Length 2, plane strain, E = rho = 1, against Euler-Bernoulli beams. Half as many elements
        # lock: cubic splines then err by 2 percent in the fourth mode without a warning.
        height = 2.0 / slenderness
        strip = body(rectangle((2.0, height)), (40, 1), degree=3, nu=0.3, held="x_min")
        omega = (_BENDING / 2.0) ** 2 * height / np.sqrt(12 * (1 - 0.3**2))
        expected, true = "accurate" if slenderness < 1e3 else "honest", formula(1j * omega)
        fields: dict[str, Any] = {"expected": expected, "tolerance": 5e-3, "lowest": 3}
        rows = {f"L/h = {slenderness:.0e}": scene({"strip": strip})}
        yield from runs(rows, ALONE, true, **fields)


def density_contrast() -> Runs:
    """Density of side a 1e-4 to 1e4 times that of side b."""
    for ratio in (1e-4, 1e-2, 1e2, 1e4):
        data = layers(upper={"E": 1.0, "rho": ratio})
        yield from runs({f"density ratio {ratio:.0e}": data}, FEW)


def elastic_contrast() -> Runs:
    """Young's modulus of side a 1e-6 to 1e6 times that of side b."""
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        data = layers(p=min(ratio, 1.0), upper={"E": ratio, "rho": 1.0})
        yield from runs({f"E ratio {ratio:.0e}": data}, FEW)


def incompressible() -> Runs:
    """Poisson's ratio 0 to 0.49999, against dense eigenvalues."""
    for nu in (0.0, 0.49, 0.499, 0.4999, 0.49999):
        yield from runs({f"ν = {nu}": layers(both={"nu": nu})}, FEW)


def anisotropic() -> Runs:
    """Orthotropic materials: moduli 1e2 and 1e4 apart, nearly indefinite, nearly incompressible."""
    axes = {"first": [2.0, 1.0, 0.0], "second": [0.0, 1.0, 0.0]}
    shear = {"G_12": 0.04, "G_13": 0.04, "G_23": 0.04, "rho": 0.35, "axes": axes}
    plain = {"E_1": 0.1, "E_2": 0.1, "E_3": 0.1, "nu_12": 0.25, "nu_13": 0.25, "nu_23": 0.25}
    changes = {
        "E_1 / E_2 = 1e2": {"E_1": 10.0},
        "E_1 / E_2 = 1e4": {"E_1": 1000.0},
        "E_1 / E_2 = 1e-4": {"E_2": 1000.0, "nu_12": 1e-4},
        "ν₁₂ = 0.9999 of its bound": {"nu_12": 0.9999, "nu_13": 0.0, "nu_23": 0.0},
        "ν = 0.4999 of each": {"nu_12": 0.4999, "nu_13": 0.4999, "nu_23": 0.4999},
        "G_12 / E = 1e-4": {"G_12": 1e-5},
    }
    material = {"kind": "orthotropic", **shear, **plain}
    rows = {row: layers(upper={"material": material | each}) for row, each in changes.items()}
    return runs(rows, FEW)


def locking() -> Runs:
    """Poisson's ratio 0.3 to 0.49999, against exact eigenvalues: locking."""
    from exact_cea.material import Material

    fields: dict[str, Any] = {"expected": "honest", "tolerance": 0.05, "warnings": ()}
    for nu in (0.3, 0.499, 0.49999):
        a, b = Material.of("0.1", str(nu), "0.35"), Material.of("1", str(nu), "1")
        true = exact("blocks", max_frequency=0.4, p=1, mu="0.3", a=a, b=b)
        for degree in (1, 2, 4):
            data = up_to(0.4, layers(both={"nu": nu, "degree": degree}, mu=_FRICTION, **FINE))
            rows = {f"ν = {nu}, degree {degree}": data}
            yield from runs(rows, chosen(SADDLE, "mortar"), true, **fields)


def units() -> Runs:
    """Units m-kg-s, mm-t-s, micrometres, kilometres."""
    brake = layers(upper=LINING, lower=STEEL, p=1e12)
    rows = {
        "m, kg, s": in_units(brake),
        "mm, t, s": in_units(brake, metre=1e3, kilogram=1e-3),
        "µm, kg, s": in_units(brake, metre=1e6),
        "µm, ng, s": in_units(brake, metre=1e6, kilogram=1e12),
        "km, kg, s": in_units(brake, metre=1e-3),
    }
    return runs(rows, instead=brake)


_FOOT = [[0.5, 0.0], [1.0, 0.0]]
_QUADRATIC = [0, 0, 0, 1, 1, 1]


def _weighted(strong: float) -> Scene:
    """A rectangle with weights 1, strong, 1 along x."""
    grid = [[[x, y] for y in (0.0, 0.25, 0.5)] for x in (0.5, 0.75, 1.0)]
    weights = [[1.0] * 3, [strong] * 3, [1.0] * 3]
    return spline_patch(grid, weights, degrees=[2, 2], knots=[_QUADRATIC, _QUADRATIC])


def _repeated(times: int) -> Scene:
    """A rectangle with a knot that is repeated, along x."""
    knots = [0.0, 0.0, 0.0, *[0.4] * times, 1.0, 1.0, 1.0]
    greville = [0.5 + 0.5 * sum(knots[i + 1 : i + 3]) / 2 for i in range(3 + times)]
    points = [[[x, y] for y in (0.0, 0.25, 0.5)] for x in greville]
    return spline_patch(points, degrees=[2, 2], knots=[knots, _QUADRATIC])


def patches() -> Runs:
    """Strong weights, repeated knots, a pole, distorted cells."""
    yield from runs({"weights 2": on_base(_weighted(2.0))}, _IGA)
    # Most of the patch is squeezed into a sliver, which few Gauss points do not resolve.
    strong = {f"weights {w}": on_base(_weighted(float(w))) for w in ("10", "1e2", "1e4", "1e-4")}
    yield from runs(strong, _IGA, expected="honest", tolerance=1e-6)
    rows = {
        "double knot": on_base(_repeated(2)),
        "skewed": on_base(patch(_FOOT, [[1.4, 0.5], [1.6, 0.5]])),
        "almost inverted": on_base(patch(_FOOT, [[0.7499, 0.5], [0.75, 0.5]])),
        "left-handed": on_base(patch([[1.0, 0.0], [0.5, 0.0]], [[1.0, 0.5], [0.5, 0.5]])),
        "pole": on_base(patch(_FOOT, [[0.75, 0.5], [0.75, 0.5]]), held=False),
    }
    yield from runs(rows, _IGA)


def inverted() -> Runs:
    """Inverted and folded patches."""
    rows = {
        "crossed": on_base(patch(_FOOT, [[1.0, 0.5], [0.5, 0.5]])),
        "folded": on_base(patch(_FOOT, [[0.8, 0.5], [0.7, 0.2]])),
        "flat": on_base(patch(_FOOT, [[0.5, 0.0], [1.0, 0.0]])),
    }
    return refused(rows, chosen(_IGA, "GPTS, penalty", "mortar"))


def _coarse(degree: int) -> Scene:
    return layers(both={"degree": degree}, upper_elements=(3, 1), lower_elements=(2, 2))


def continuity() -> Runs:
    """Continuity 0 to p - 1 of splines."""
    for p in (2, 4):
        for c in range(p):  # collocation points cluster at knots of low continuity
            fields = {f"bodies.{n}.mesh.iga.continuity": [c] * 2 for n in ("upper", "lower")}
            yield from runs({f"degree {p}, C{c}": changed(_coarse(p), fields)}, _IGA)


def degrees() -> Runs:
    """Degrees 1 to 8."""
    some = chosen(WAYS, "node", "Greville", "GPTS, penalty", "segments, saddle", "mortar")
    true = exact("blocks", max_frequency=0.4, p=1, mu="0.3")
    for p in range(1, 9):
        ways = some if p < 5 else chosen(some, backend="iga")
        yield from runs({f"degree {p}": _coarse(p)}, ways)
    for p in range(3, 9):
        ways = MORTAR if p < 5 else chosen(MORTAR, backend="iga")
        data = up_to(0.4, layers(both={"degree": p}, mu=_FRICTION))
        yield from runs({f"degree {p}, exact": data}, ways, true, tolerance=1e-3)


def simplices() -> Runs:
    """Triangles and tetrahedra of degree 1 to 4."""
    names = "node", "GPTS, penalty", "GPTS, saddle", "segments", "mortar"
    ways, size = chosen(WAYS, *names, backend="fe"), (1.0, 1.0, 0.5)
    of_cell = {"triangle": layers(), "tetrahedron": boxes((size, (2, 1, 1)), (size, (1, 2, 1)))}
    for degree in (1, 2, 4):
        for cell, data in of_cell.items():
            if degree < 4 or cell == "triangle":
                fields: dict[str, Any] = {}
                for name in ("upper", "lower"):
                    fields[f"bodies.{name}.mesh.fe.cell"] = cell
                    fields[f"bodies.{name}.mesh.fe.degree"] = degree
                yield from runs({f"{cell}, degree {degree}": changed(data, fields)}, ways)


def mesh_files() -> Runs:
    """Bodies from mesh files."""
    ways = chosen(PAIR, backend="fe")
    given: dict[str, Any]
    for row, data, given in (
        ("metres", layers(), {}),
        ("micrometres", layers(), {"unit": "um"}),
        ("feet", layers(), {"unit": "ft"}),
        ("elements of aspect 1e4", layers(height=1e-4), {}),
        ("node numbers to 1e9", layers(), {"step": 10**7}),
        ("a pad that ends on its base", pad(), {"unit": "mm"}),
    ):
        yield from runs({row: data}, ways, problem=partial(of_mesh_file, **given))
    for row, name, value in (
        ("no unit", "unit", None),
        ("two bodies as one", "part", None),
        ("a set that is not there", "faces", {"y_min": "nowhere"}),
    ):
        given = {"problem": partial(of_mesh_file, geometry={name: value}), "names": name}
        yield from runs({row: layers()}, ways, None, expected="refused", **given)
