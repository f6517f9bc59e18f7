"""Materials and units far apart."""

from functools import partial

from comparisons.stability.parts.case import HONEST, NONE, Case, Rows
from comparisons.stability.parts.references import Reference, benign, exact
from comparisons.stability.parts.scenes import LINING, STEEL, Scene, in_units, layers, up_to
from comparisons.stability.parts.ways import FEW, MORTAR, chosen

SUBJECT = "materials and units"
_BRAKE = layers(upper=LINING, lower=STEEL, p=1e12)
_UNITS = {
    "m, kg, s": (1.0, 1.0),
    "mm, t, s": (1e3, 1e-3),
    "µm, kg, s": (1e6, 1.0),
    "µm, ng, s": (1e6, 1e12),
    "km, kg, s": (1e-3, 1.0),
}
"""One metre and one kilogram in each."""


def _nearly_incompressible(nu: float, degree: int) -> Scene:
    both = {"nu": nu, "degree": degree}
    return up_to(
        0.4,
        layers(
            upper=both,
            lower=both,
            upper_elements=(8, 3),
            lower_elements=(7, 4),
            mu="0.3*abs(sin(pi*x/2))",
        ),
    )


def _exact_layers(nu: float, _: Scene) -> Reference:
    from exact_cea.material import Material

    a, b = Material.of("0.1", str(nu), "0.35"), Material.of("1", str(nu), "1")
    return exact("blocks", max_frequency=0.4, p=1, mu="0.3", a=a, b=b)


CASES = {
    "density_contrast": Case(
        "Density of side a 1e-4 to 1e4 times that of side b",
        Rows(
            {
                f"density ratio {ratio:.0e}": layers(upper={"E": 1.0, "rho": ratio})
                for ratio in (1e-4, 1e-2, 1e2, 1e4)
            },
            FEW,
        ),
    ),
    "elastic_contrast": Case(
        "Young's modulus of side a 1e-6 to 1e6 times that of side b",
        Rows(
            {
                f"E ratio {ratio:.0e}": layers(p=min(ratio, 1.0), upper={"E": ratio, "rho": 1.0})
                for ratio in (1e-6, 1e-3, 1e3, 1e6)
            },
            FEW,
        ),
    ),
    "incompressible": Case(
        "Poisson's ratio 0 to 0.49999: the algebra",
        Rows(
            {
                f"ν = {nu}": layers(upper={"nu": nu}, lower={"nu": nu})
                for nu in (0.0, 0.49, 0.499, 0.4999, 0.49999)
            },
            FEW,
        ),
    ),
    "locking": Case(
        "Poisson's ratio 0.3 to 0.49999: what it costs in truth",
        *(
            Rows(
                {f"ν = {nu}, degree {d}": _nearly_incompressible(nu, d) for d in (1, 2, 4)},
                chosen(MORTAR, "mortar, saddle"),
                partial(_exact_layers, nu),
                expected=HONEST,
                tolerance=0.05,
                warnings=NONE,
            )
            for nu in (0.3, 0.499, 0.49999)
        ),
    ),
    "units": Case(
        "Units m-kg-s, mm-t-s, micrometres, kilometres",
        Rows(
            {name: in_units(_BRAKE, metre=m, kilogram=kg) for name, (m, kg) in _UNITS.items()},
            true=benign,
            instead=_BRAKE,
        ),
    ),
}
