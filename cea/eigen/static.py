"""Static equilibrium K x = load by one factorisation."""

from typing import Any

from cea.eigen.pencil import Pencil, release
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError
from cea.timing import StageTimer

_SINGULAR = "the stiffness is singular: the bodies are not held by supports and contacts"


def solve_static(pencil: Pencil, load: Any, timer: StageTimer | None = None) -> Any:
    """Displacements under a load.

    Parameters
    ----------
    pencil
        Its stiffness, at its own parameters; symmetric without friction.
    load
        Forces (N), PETSc vector.
    timer
        Counts factorisation.

    Returns
    -------
    PETSc.Vec
        Free displacements (m).

    Raises
    ------
    ConvergenceError
        When the stiffness is singular.
    """
    timer = timer or StageTimer()
    with timer("assembly"):
        matrices = pencil.at()
    x = load.duplicate()
    with timer("factorisation"):
        try:
            factors = Shifted(matrices)
        except ConvergenceError as error:
            raise ConvergenceError(_SINGULAR) from error
        factors.solve(load, x)
        factors.free()
    release(matrices)
    return x
