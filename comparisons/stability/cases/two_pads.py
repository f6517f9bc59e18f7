"""Two pads on one disc, one of them a lining bonded to a backplate, in parts lifted off."""

from collections.abc import Iterator

from comparisons.stability.parts.case import MESH_AND_PENALTY, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, body, contact, rectangle, scene
from comparisons.stability.parts.ways import WAYS


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
    return scene(
        {
            "disc": body(rectangle((2.0, 0.3), (0.0, -0.3)), (7, 2), supports=ends),
            "lining": body(rectangle((0.6, 0.2), (0.7, 0.0)), (3, 1), E=0.05),
            "backplate": body(
                rectangle((0.6, 0.1), (0.7, 0.2)), (4, 1), E=2.0, supports=[{"surface": "y_max"}]
            ),
            "pad": body(
                rectangle((0.5, 0.25), (0.9, -0.55)), (3, 1), E=0.1, supports=[{"surface": "y_min"}]
            ),
        },
        above=contact("lining.y_min", "disc.y_max", p=upper),
        below=contact("pad.y_max", "disc.y_min", p=lower),
        joint=contact("lining.y_max", "backplate.y_min", **bond),
    )


_ROWS: dict[str, tuple[float | str, float | str, float]] = {
    "both closed": (1.0, 1.0, 1e3),
    "below stiff by 1e6": (1.0, 1e6, 1e3),
    "above lifted in part": ("where(x < 0.95, 0, 3.0)", 1.0, 1e3),
    "both lifted in part, bond of 1e8": (
        "where(abs(x - 1) < 0.1, 0, 1.0)",
        "2.0*maximum(1.2 - x, 0)",
        1e8,
    ),
    "bond tied": (1.0, 1.0, float("inf")),
    "bond weak": (1.0, 1.0, 1e-6),
}


@case("Two pads on a disc, a lining bonded to its backplate", subject="several contacts")
def two_pads_and_a_bond() -> Iterator[Run]:
    """Several contacts share a body, one is bonded, and some have lifted off in part."""
    for row, stiffnesses in _ROWS.items():
        for way in WAYS:
            data = way.of(two_pads(*stiffnesses))
            yield Run(
                *(row, way, OfScene(data), dense(data)),
                tolerance=1e-7,
                warnings=MESH_AND_PENALTY,
            )
