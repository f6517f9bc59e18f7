"""Pieces of a pencil that a body brings: stiffness and mass, damping and rotation.

By the path of the body in a scene, ``bodies.<name>``, the parameters are ``.material.E`` and
``.rho``, ``.damping.alpha`` and ``.beta``, ``.rotation.rate``; modal damping has its own.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cea.body import Body
from cea.damping import ModalDamping, RayleighDamping
from cea.eigen.parameters import Coefficient, Monomial, Parameter
from cea.eigen.pencil import Role, Term
from cea.petsc import Mat
from cea.rotation import Rotation


@dataclass(frozen=True)
class Motion:
    """What acts on the velocities of a body.

    Parameters
    ----------
    damping
        Its Rayleigh damping; None without.
    rotation
        Its rotation; None without.
    modal
        Its modal damping (:mod:`cea.system.modal_damping`); None without.
    """

    damping: RayleighDamping | None = None
    rotation: Rotation | None = None
    modal: ModalDamping | None = None

    @property
    def circulates(self) -> bool:
        """Whether damping is carried along by a rotation."""
        damped = self.damping is not None or self.modal is not None
        return damped and self.rotation is not None

    @property
    def turns_modes(self) -> bool:
        """Whether modal damping is carried along by a rotation."""
        return self.modal is not None and self.rotation is not None

    @property
    def in_equilibrium(self) -> bool:
        """Whether it acts on displacements that are at rest in space."""
        convective = self.rotation is not None and self.rotation.convective_stiffness
        return self.circulates or convective


STILL = Motion()
"""Neither damped nor rotating."""


def body_terms(
    path: str, body: Body, motion: Motion, embedded: Callable[[Mat], Mat], *, with_mass: bool
) -> Iterator[Term]:
    """K and M of a body, and what damping and rotation make of it.

    Modal damping and what a rotation carries along of damping come from
    :mod:`cea.system.modal_damping` and :mod:`cea.system.rotating_damping`.

    Parameters
    ----------
    path
        Path of the body in a scene.
    body
        The body.
    motion
        Its damping and rotation.
    embedded
        Takes a matrix of the body to one of all unknowns.
    with_mass
        Whether there is mass, and velocities count; otherwise only the stiffness is made.
    """
    for role, matrix, coefficient in _pieces(path, body, embedded, with_mass):
        yield Term(role, matrix, coefficient)
        if with_mass and motion.damping is not None:
            factor = {"mass": "alpha", "stiffness": "beta"}[role]
            yield Term("damping", matrix, coefficient.times(f"{path}.damping.{factor}"))
    if motion.rotation is not None:
        if with_mass:
            yield _gyroscopic_term(path, body, motion.rotation, embedded)
        if motion.rotation.convective_stiffness:
            yield _convective_term(path, body, motion.rotation, embedded)


def part_terms(
    path: str, body: Body, nodes: NDArray[np.bool_], embedded: Callable[[Mat], Mat]
) -> Iterator[Term]:
    """K without springs and M of a part of a body (:meth:`cea.body.Body.part`).

    Parameters
    ----------
    path, body, embedded
        As for :func:`body_terms`.
    nodes
        Which scalar dofs of this rank all its cells are among, shape (n_local,).
    """
    stiffness, mass = body.part(nodes)
    yield Term("stiffness", embedded(stiffness), of_stiffness(path, body))
    yield Term("mass", embedded(mass), of_mass(path, body))


def _pieces(
    path: str, body: Body, embedded: Callable[[Mat], Mat], with_mass: bool
) -> Iterator[tuple[Role, Mat, Coefficient]]:
    """K and M of a body; springs do not grow with E."""
    yield "stiffness", embedded(body.stiffness()), of_stiffness(path, body)
    if (springs := body.spring_stiffness()) is not None:
        E = {f"{path}.material.E": (body.material.E, 1.0)}
        rest = Coefficient((Monomial(), Monomial(-1.0, E)))
        yield "stiffness", embedded(springs), rest
    if with_mass:
        yield "mass", embedded(body.mass()), of_mass(path, body)


def of_stiffness(path: str, body: Body) -> Coefficient:
    """Young's modulus of a body, relative to its own."""
    return Coefficient.of({f"{path}.material.E": (body.material.E, 1.0)})


def of_mass(path: str, body: Body) -> Coefficient:
    """Density of a body, relative to its own."""
    return Coefficient.of({f"{path}.material.rho": (float(body.material.rho or 0), 1.0)})


def _gyroscopic_term(
    path: str, body: Body, rotation: Rotation, embedded: Callable[[Mat], Mat]
) -> Term:
    """Omega Y of a body."""
    coefficient = of_mass(path, body).times(f"{path}.rotation.rate")
    return Term("damping", embedded(body.gyroscopic(rotation)), coefficient, symmetric=False)


def _convective_term(
    path: str, body: Body, rotation: Rotation, embedded: Callable[[Mat], Mat]
) -> Term:
    """- Omega^2 Z of a body."""
    coefficient = of_mass(path, body).times(f"{path}.rotation.rate", 2.0, factor=-1.0)
    return Term("stiffness", embedded(body.convective_stiffness(rotation)), coefficient)


def body_parameters(
    path: str, body: Body, motion: Motion, *, with_mass: bool
) -> Iterator[Parameter]:
    """Parameters of a body; path, body, motion and mass as for :func:`body_terms`."""
    yield Parameter(f"{path}.material.E", body.material.E, "N/m^2", positive=True)
    if with_mass or motion.in_equilibrium:
        rho = float(body.material.rho or 0)
        yield Parameter(f"{path}.material.rho", rho, "kg/m^3", positive=True)
    if motion.damping is not None:
        yield Parameter(f"{path}.damping.alpha", motion.damping.alpha, "1/s")
        yield Parameter(f"{path}.damping.beta", motion.damping.beta, "s")
    if motion.modal is not None:
        from cea.system.modal_damping import modal_parameters

        yield from modal_parameters(path, motion.modal)
    if motion.rotation is not None:
        yield Parameter(f"{path}.rotation.rate", motion.rotation.rate, "rad/s")
