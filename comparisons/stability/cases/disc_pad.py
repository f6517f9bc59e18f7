"""A disc and a pad in space, with friction and contact far beyond those of a brake."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, body, contact, scene
from comparisons.stability.parts.ways import WAYS, chosen


def _disc_pad(mu: float, P: float, degree: int, disc: tuple[int, int, int]) -> Scene:
    pad_at = {"inner_radius": 0.09, "outer_radius": 0.14, "bottom": 0.012, "top": 0.027}
    disc_at = {"inner_radius": 0.06, "outer_radius": 0.15, "bottom": 0.0, "top": 0.012}
    return scene(
        {
            "pad": body(
                {"shape": "sector", "start": 25.0, "end": 65.0, **pad_at},
                (2, 3, 1),
                degree=degree,
                E=8e9,
                rho=2500.0,
                supports=[{"surface": "top"}],
            ),
            "disc": body(
                {"shape": "annulus", **disc_at},
                disc,
                degree=degree,
                E=2.1e11,
                rho=7800.0,
                supports=[{"surface": "inner"}],
            ),
        },
        contact=contact(
            "pad.bottom",
            "disc.top",
            P=P,
            mu=mu,
            max_missed=0.2,
            friction_direction_on_a={"circumferential_about": [0.0, 0.0, 1.0]},
        ),
    )


@case("Disc and pad, friction to 2.5, P to 1e13 N/m", subject="friction and spectra")
def disc_pad() -> Iterator[Run]:
    """Modes that grow by 1e5 1/s, far from the frequencies looked at."""
    for mu, P in ((0.0, 1e9), (0.7, 1e9), (2.5, 1e11), (2.5, 1e13)):
        for way in chosen(WAYS, "GPTS, penalty", "GPTS, saddle", "mortar"):
            coarse = (1, (3, 20, 1)) if way.backend == "fe" else (2, (2, 12, 1))
            data = way.of(_disc_pad(mu, P, *coarse))
            row = f"μ = {mu:g}, P = {P:.0e} N/m"
            yield Run(row, way, OfScene(data), dense(data), tolerance=1e-7)
