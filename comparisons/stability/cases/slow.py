"""A system so slow that its growth is below any absolute threshold one would think of."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import benign
from comparisons.stability.parts.scenes import Scene, changed, sprag
from comparisons.stability.parts.ways import WAYS, chosen


def _slowed(scene: Scene, factor: float) -> Scene:
    """Everything takes so many times longer."""
    heavier = {f"bodies.{name}.material.rho": factor**2 for name in scene["bodies"]}
    return changed(scene, heavier)


@case("Systems with frequencies of 1e-6 to 1e6 Hz", subject="friction and spectra")
def slow() -> Iterator[Run]:
    """A threshold of growth is relative to the frequency where the scene gives none."""
    for factor in (1e-6, 1e-3, 1e3, 1e6):
        for way in chosen(WAYS, "GPTS, penalty", "mortar"):
            fast = way.of(sprag(mu=1.0))
            true = benign(fast, 1 / factor)
            yield Run(f"{factor:.0e} times slower", way, OfScene(_slowed(fast, factor)), true)
