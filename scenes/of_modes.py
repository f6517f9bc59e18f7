"""What modes of a scene say of themselves, fresh or opened from a file."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.body import Complexes, Floats
from cea.eigen.spectrum import Spectrum, Verdict
from scenes.matrix_scene import MatrixScene
from scenes.names import backend_name
from scenes.read import Scene
from scenes.spec.analysis import ComplexEigenvalueAnalysis


class OfModes:
    """Modes of a scene.

    Attributes
    ----------
    scene
        The scene as run.
    modes
        Its eigenvalues with their errors and the window that was searched.
    """

    scene: Scene | MatrixScene
    modes: Spectrum

    @property
    def analysis(self) -> ComplexEigenvalueAnalysis:
        """The analysis of the scene."""
        assert isinstance(self.scene.analysis, ComplexEigenvalueAnalysis)
        return self.scene.analysis

    @property
    def eigenvalues(self) -> Complexes:
        """Lambda (1/s) by rising frequency, shape (n,)."""
        return self.modes.eigenvalues

    @property
    def frequencies(self) -> Floats:
        """Frequencies (Hz), shape (n,)."""
        return self.modes.frequencies

    @property
    def growth_rates(self) -> Floats:
        """Growth rates (1/s), shape (n,)."""
        return self.modes.growth_rates

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """Modes that grow faster than the scene's threshold and their errors explain, (n,)."""
        return self.modes.unstable(self.analysis.growth_threshold)

    @property
    def verdict(self) -> Verdict:
        """Of the whole window: stable, unstable, or undecided."""
        return self.modes.verdict(self.analysis.growth_threshold)

    def most_unstable(self, count: int) -> list[int]:
        """Numbers, from 0, of the most unstable modes; of the first ones where none is."""
        unstable = np.flatnonzero(self.unstable)
        if not len(unstable):
            return list(range(min(count, len(self.modes))))
        order = np.argsort(-self.growth_rates[unstable], kind="stable")
        return unstable[order][:count].tolist()

    def table(self) -> list[dict[str, Any]]:
        """A row for each mode, as :meth:`cea.eigen.spectrum.Spectrum.table` has them."""
        return self.modes.table(self.analysis.growth_threshold)

    def title(self, mode: int) -> str:
        """A mode in words: backend, number from 1, frequency and growth rate."""
        return (
            f"{backend_name(self.scene.backends)}, mode {mode + 1}: "
            f"{self.frequencies[mode]:.2f} Hz, growth rate {self.growth_rates[mode]:+.2f} 1/s"
        )

    def __repr__(self) -> str:
        return f"{self.scene.name}: {self.modes.text(self.analysis.growth_threshold)}"
