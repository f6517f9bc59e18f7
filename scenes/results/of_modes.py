"""What modes of a scene say of themselves, fresh or opened from a file."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from cea.arrays import Complexes, Floats
from cea.eigen.classify import RunWord
from cea.eigen.mode_table import SIGNS, ModeTable, html_table
from cea.eigen.spectrum import Spectrum
from cea.errors import InputError
from scenes.spec.matrices import MatrixScene
from scenes.spec.names import backend_name
from scenes.spec.reading import Scene
from scenes.spec.analysis import ComplexEigenvalueAnalysis


class OfModes(ABC):
    """Modes of a scene.

    A mode that is named by a number has one from 1, as tables, files, pictures show it; arrays of
    modes are indexed from 0, as all arrays are.

    Attributes
    ----------
    scene
        The scene as run.
    modes
        Its eigenvalues with their errors, the window that was searched, and all warnings.
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
        """Modes that are called unstable with the scene's threshold, shape (n,)."""
        return self.modes.unstable(self.analysis.growth_threshold)

    @property
    def verdict(self) -> RunWord:
        """The word of the whole window, as :func:`cea.eigen.classify.classify_run` has it."""
        return self.modes.verdict(self.analysis.growth_threshold)

    @property
    def damping_ratios(self) -> Floats:
        """-Re lambda / abs(lambda), shape (n,): below zero where a mode grows, NaN where rigid."""
        return self.modes.damping_ratios

    @property
    @abstractmethod
    def dofs(self) -> int:
        """Free dofs."""

    def steady_lines(self) -> list[str]:
        """What the contacts carry in steady sliding, a line for each half pass."""
        return []

    def most_unstable(self, count: int) -> list[int]:
        """Indices, from 0, of the most unstable modes; of the first ones where none is."""
        unstable = np.flatnonzero(self.unstable)
        if not len(unstable):
            return list(range(min(count, len(self.modes))))
        order = np.argsort(-self.growth_rates[unstable], kind="stable")
        return unstable[order][:count].tolist()

    def index(self, mode: int | None = None) -> int:
        """Index, from 0, of a mode in all arrays.

        Parameters
        ----------
        mode
            Its number, from 1; by default the most unstable one.

        Raises
        ------
        InputError
            When there is no such mode.
        """
        if mode is None and len(self.modes):
            return self.most_unstable(1)[0]
        if mode is None or not 1 <= mode <= len(self.modes):
            raise InputError("mode", mode, f"the number of a mode, from 1 to {len(self.modes)}")
        return int(mode) - 1

    def table(self) -> ModeTable:
        """A row for each mode, as :meth:`cea.eigen.spectrum.Spectrum.table` has them."""
        return self.modes.table(self.analysis.growth_threshold)

    @property
    def summary(self) -> str:
        """How many modes have which word, the threshold and the verdict, in a line."""
        return f"{self.scene.name}: {self.modes.headline(self.analysis.growth_threshold)}"

    @property
    def first_lines(self) -> list[str]:
        """The summary, and a hint where modes grow just above the window."""
        return [self.summary, *self.modes.hints]

    def title(self, index: int) -> str:
        """A mode, by its index, in words: backend, number from 1, frequency and growth rate."""
        begin = f"{backend_name(self.scene.backends)}, mode {index + 1}: "
        if self.modes.rigid[index]:
            return f"{begin}rigid motion"
        return (
            f"{begin}{self.frequencies[index]:.2f} Hz, "
            f"growth rate {self.growth_rates[index]:+.2f} 1/s"
        )

    def _notes(self) -> Sequence[str]:
        """What stands below the table: dofs, evidence of the window, steady sliding, warnings."""
        warnings = [
            f"warning ({warning.kind}): {warning.message}" for warning in self.modes.warnings
        ]
        evidence = f"window: {self.modes.window.evidence}"
        return [f"{self.dofs} dofs", evidence, *self.steady_lines(), *warnings]

    def __repr__(self) -> str:
        return "\n".join([*self.first_lines, repr(self.table()), SIGNS, *self._notes()])

    def _repr_html_(self) -> str:
        notes = "<br>".join(escape(line) for line in (SIGNS, *self._notes()))
        first = "<br>".join(escape(line) for line in self.first_lines)
        return f"<p><b>{first}</b></p>{html_table(self.table())}<p>{notes}</p>"
