"""Thresholds along which the state of steady sliding is sought anew at every value."""

from collections.abc import Callable, Mapping, Sequence

from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.petsc import Mat
from cea.system.coupled import CoupledSystem
from cea.warned import ResultWarning


def moves_the_state(pencil: Pencil, parameter: str) -> bool:
    """Whether a state of steady sliding depends on a parameter: the stiffness of its pencil does.

    Parameters
    ----------
    pencil
        The pencil that is linearised about the state.
    parameter
        Name of one of its parameters.
    """
    return parameter in pencil.at_rest().names


def kept_state_warning(parameters: str) -> ResultWarning:
    """What is told where such parameters change and the state is kept.

    Parameters
    ----------
    parameters
        In words.
    """
    return ResultWarning(
        "steady-state-kept",
        f"the state of steady sliding depends on {parameters}, and is kept in derivatives and "
        "thresholds: closed zones and contact stiffness are those of the scene; a threshold with "
        "follow_steady_state seeks it at each value",
        {"parameters": parameters},
    )


class FollowingDriver:
    """A driver of thresholds that solves a system of its own at each value of some parameters.

    Parameters
    ----------
    pencil
        The pencil at the scene's own value, whose parameters may be asked for.
    names
        The parameters, which have one value.
    system_at
        The system, linearised about its state of steady sliding, at a value.
    """

    def __init__(
        self, pencil: Pencil, names: Sequence[str], system_at: Callable[[float], CoupledSystem]
    ) -> None:
        self.pencil = pencil
        self._names = tuple(names)
        self._system_at = system_at
        self._at: tuple[float, KrylovSchur] | None = None
        self._before = (0, 0)

    @property
    def solves(self) -> int:
        """Eigenvalue problems solved."""
        return self._before[0] + (self._at[1].solves if self._at else 0)

    @property
    def factorisations(self) -> int:
        """Matrices factorised for them."""
        return self._before[1] + (self._at[1].factorisations if self._at else 0)

    def solve(self, max_frequency: float, changes: Mapping[str, float]) -> Modes:
        """All modes up to a frequency at a value."""
        return self._driver(changes).solve(max_frequency)

    def nearest(self, kappa: float, count: int, changes: Mapping[str, float]) -> Modes:
        """So many modes nearest to kappa at a value."""
        return self._driver(changes).nearest(kappa, count)

    def quadratic(self, changes: Mapping[str, float]) -> bool:
        """Whether the pencil is damped or rotates at a value."""
        return self._driver(changes).quadratic()

    def mass(self, values: Mapping[str, float]) -> Mat:
        """M of the pencil that was solved last, PETSc AIJ (kg)."""
        return self._driver(values).mass(values)

    def free(self) -> None:
        """Free what is kept between solves."""
        if self._at is not None:
            self._before = self.solves, self.factorisations
            self._at[1].free()
            self._at = None

    def _driver(self, values: Mapping[str, float]) -> KrylovSchur:
        value = values[self._names[0]]
        if self._at is None or self._at[0] != value:
            self.free()
            self._at = value, KrylovSchur(self._system_at(value).pencil())
        return self._at[1]
