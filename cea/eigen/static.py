"""Static equilibrium K x = load by one factorisation."""

from cea.eigen.pencil import Pencil, release
from cea.eigen.shifted import Shifted
from cea.errors import ConvergenceError, InputError
from cea.petsc import Vec
from cea.timing import StageTimer

_SINGULAR = "the stiffness is singular: the bodies are not held by supports and contacts"


def solve_static(pencil: Pencil, load: Vec | None, timer: StageTimer | None = None) -> Vec:
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
    InputError
        When there is no load.
    ConvergenceError
        When the stiffness is singular.
    """
    if load is None:
        raise InputError("load", None, "forces: the system was coupled without")
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
