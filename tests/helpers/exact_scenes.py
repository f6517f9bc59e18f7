"""Scenes of problems with exact eigenvalues, with parameters of the files or at random."""

from dataclasses import dataclass
from math import tau

import numpy as np

from exact_cea.reference import whole_spectrum
from scenes.spec.reading import load_scene

_BEYOND = 1.05
UNIT = {"drum": 1.0, "blocks": 1.0, "ring": 1e12}
"""Contact stiffness p of the scenes (N/m^3)."""


@dataclass(frozen=True)
class ExactScene:
    """A scene and what its eigenvalues are.

    Parameters
    ----------
    name
        Name of the scene.
    p, mu
        Contact stiffness relative to that of the scene, friction coefficient.
    """

    name: str
    p: float = 1.0
    mu: float = 0.3

    @property
    def overrides(self):
        """Fields of the scene, as ``--set`` takes them."""
        mu = f'"{self.mu!r}*sin(pi*x/2)"' if self.name == "blocks" else repr(self.mu)
        p = self.p * UNIT[self.name]
        return f"contacts.interface.mu={mu}", f"contacts.interface.p={p!r}"

    def exact(self):
        """Eigenvalues with Im >= 0 to a little beyond the window of the scene."""
        top = load_scene(self.name).analysis.max_frequency
        found = whole_spectrum(
            self.name,
            max_frequency=_BEYOND * tau * top,
            p=repr(self.p * UNIT[self.name]) if self.name == "ring" else repr(self.p),
            mu=repr(self.mu),
        )
        return np.array(found.values)


def random_scenes(count, seed=20261122):
    """Problems in turn with p over four decades and mu up to 1, at random."""
    rng = np.random.default_rng(seed)
    names = ("drum", "blocks", "ring")
    return [
        ExactScene(
            names[i % 3],
            float(f"{10 ** rng.uniform(-2, 2):.3g}"),
            float(f"{rng.uniform(0.05, 1.0):.3g}"),
        )
        for i in range(count)
    ]
