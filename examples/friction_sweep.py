"""Growth rates against friction: bodies and contact points are computed once for the sweep."""

import numpy as np

from scenes import assemble, load_scene

COARSE = {
    "bodies.pad.mesh.iga.elements": [3, 5, 1],
    "bodies.disc.mesh.iga.elements": [6, 28, 1],
    "analysis.max_frequency": 8500.0,
}


def growth_rates(frictions: np.ndarray) -> np.ndarray:
    """Return the largest growth rate (1/s) at each friction coefficient."""
    assembled = assemble(load_scene("disc_pad").change(COARSE))
    return np.array([assembled.modes(mu=float(mu)).growth_rates.max() for mu in frictions])


if __name__ == "__main__":
    steps = np.linspace(0.0, 1.0, 6)
    for mu, growth in zip(steps, growth_rates(steps), strict=True):
        print(f"mu = {mu:.1f}: {growth:8.2f} 1/s")
