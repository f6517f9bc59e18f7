"""Two discretisations of one scene: prolongation, errors of eigenvalues, modes to start from."""

from collections.abc import Mapping

from cea.body import Body
from cea.errors import InputError
from cea.nested.prolongation import Prolongation, of_system
from scenes.read import Scene


def prolongation(
    coarse: Mapping[str, Body], fine: Mapping[str, Body], scene: Scene
) -> Prolongation:
    """Prolongation from the unknown displacements of a scene to those of a finer one; collective.

    Parameters
    ----------
    coarse, fine
        Bodies of the scenes by name, on the same backends.
    scene
        The finer scene.

    Raises
    ------
    InputError
        When bodies differ in name, shape or backend.
    """
    if list(coarse) != list(fine):
        raise InputError("bodies", list(fine), f"those of the coarse scene: {', '.join(coarse)}")
    return of_system([_of_body(coarse[name], fine[name], scene, name) for name in fine])


def _of_body(coarse: Body, fine: Body, scene: Scene, name: str) -> Prolongation:
    """Prolongation of one body, by its backend."""
    if scene.bodies[name].backend == "fe":
        from fe_cea.body import FEBody
        from fe_cea.prolongation import prolongation as lagrange

        if isinstance(coarse, FEBody) and isinstance(fine, FEBody):
            return lagrange(coarse, fine)
    else:
        from iga_cea.body import NurbsBody
        from iga_cea.prolongation import prolongation as nurbs

        if isinstance(coarse, NurbsBody) and isinstance(fine, NurbsBody):
            return nurbs(coarse, fine)
    kinds = type(coarse).__name__, type(fine).__name__
    raise InputError(f"bodies.{name}.backend", kinds, "one backend for both discretisations")
