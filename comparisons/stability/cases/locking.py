"""Poisson's ratios next to a half on coarse meshes, against exact eigenvalues."""

from collections.abc import Iterator

from comparisons.stability.parts.case import HONEST, NONE, Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import exact
from comparisons.stability.parts.scenes import changed, layers
from comparisons.stability.parts.ways import MORTAR, chosen

_FREQUENCY = 0.4


@case("Poisson's ratio 0.3 to 0.49999: what it costs in truth", subject="materials and units")
def locking() -> Iterator[Run]:
    """A low degree locks where the volume cannot change; a result must not hide it."""
    for nu in (0.3, 0.499, 0.49999):
        for degree in (1, 2, 4):
            for way in chosen(MORTAR, "mortar, saddle"):
                scene = layers(
                    upper={"nu": nu, "degree": degree},
                    lower={"nu": nu, "degree": degree},
                    upper_elements=(8, 3),
                    lower_elements=(7, 4),
                    mu="0.3*abs(sin(pi*x/2))",
                )
                data = changed(way.of(scene), {"analysis.max_frequency": _FREQUENCY})
                yield Run(
                    f"ν = {nu}, degree {degree}",
                    way,
                    OfScene(data),
                    exact("blocks", max_frequency=_FREQUENCY, p=1, mu="0.3", **_materials(nu)),
                    HONEST,
                    tolerance=0.05,
                    warnings=NONE,
                )


def _materials(nu: float) -> dict[str, object]:
    from exact_cea.material import Material

    return {"a": Material.of("0.1", str(nu), "0.35"), "b": Material.of("1", str(nu), "1")}
