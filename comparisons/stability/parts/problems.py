"""What a run solves: a scene, or a pencil of given matrices."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.pencil import Pencil
from cea.matrices import distributed
from cea.petsc import MPI
from comparisons.stability.parts.answers import Answer, StressAnswer, answer_of, kinds
from scenes.describe import describe
from scenes.read import read_scene
from scenes.results import ModesResult
from scenes.run import run_scene
from scenes.stored import as_json


class Problem(Protocol):
    """Something that is solved."""

    def solve(self, max_frequency: float | None) -> Answer:
        """Solve it.

        Parameters
        ----------
        max_frequency
            Upper end of the modes asked for (Hz), where the problem does not say it.

        Raises
        ------
        InputError, SceneError
            When it is refused.
        ConvergenceError
            When it has no answer.
        """
        ...


@dataclass(frozen=True)
class OfScene:
    """A scene as plain data.

    Parameters
    ----------
    data
        What a scene file holds; ``analysis.max_frequency`` may be left to the reference.
    """

    data: Mapping[str, Any]

    def solve(self, max_frequency: float | None) -> Answer:
        """Read the scene and run it; what it gives can be stored."""
        data = deepcopy(dict(self.data))
        if data["analysis"]["kind"] == "cea":
            data["analysis"].setdefault("max_frequency", max_frequency or 1.0)
        result = run_scene(read_scene(data))
        as_json(describe(result))
        if isinstance(result, ModesResult):
            threshold, dofs = result.analysis.growth_threshold, result.system.size
            return answer_of(result.modes, result.warnings, threshold, dofs)
        stresses = [side.sigma_n for sides in result.stresses.values() for side in sides.values()]
        return StressAnswer(np.concatenate(stresses), kinds(result.warnings), result.system.size)


@dataclass(frozen=True)
class OfMatrices:
    """Given matrices: lambda^2 M + K - F.

    Parameters
    ----------
    stiffness, mass, friction
        Symmetric K, M and unsymmetric F, shape (n, n).
    """

    stiffness: Floats
    mass: Floats
    friction: Floats

    def solve(self, max_frequency: float | None) -> Answer:
        """Modes up to a frequency."""
        assert max_frequency is not None
        n = len(self.stiffness)
        S, M, F = (
            distributed(csr_array(matrix), (n, n), MPI.COMM_SELF)
            for matrix in (self.stiffness, self.mass, self.friction)
        )
        for matrix in (S, M):
            matrix.setOption(matrix.Option.SYMMETRIC, True)
        modes = solve_modes(Pencil.of(S, M, F if self.friction.any() else None), max_frequency)
        return answer_of(modes, modes.warnings, None, n)
