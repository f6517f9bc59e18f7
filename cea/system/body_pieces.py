"""Pieces of a pencil that all bodies of a system bring, each made once."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from cea.body import Body
from cea.eigen.parameters import Parameter
from cea.eigen.pencil import Term
from cea.eigen.unformed import CirculatoryTerm, LowRankTerm
from cea.petsc import Mat
from cea.system.body_terms import STILL, Motion, body_parameters, body_terms
from cea.system.embedding import Embedding

if TYPE_CHECKING:  # brought in where modes are damped, or damping rotates
    from cea.system.modal_damping import DampedModes
    from cea.system.rotating_damping import RotatingDamping


@dataclass(frozen=True)
class BodyPieces:
    """Bodies, and what acts on their velocities.

    Parameters
    ----------
    bodies
        Bodies by name, in the order of the unknowns.
    motions
        Damping and rotation of bodies that have any, by name.
    with_mass
        Whether they have mass, and velocities count.
    comm
        Communicator (petsc4py).
    """

    bodies: Mapping[str, Body]
    motions: Mapping[str, Motion]
    with_mass: bool
    comm: Any

    @property
    def rotates(self) -> bool:
        """Whether a body rotates."""
        return any(motion.rotation is not None for motion in self.motions.values())

    @property
    def softens(self) -> bool:
        """Whether a rotation softens a body that is at rest in space."""
        rotations = (motion.rotation for motion in self.motions.values())
        return any(each is not None and each.convective_stiffness for each in rotations)

    @cached_property
    def among(self) -> dict[str, Embedding]:
        """The unknowns of each body among those of all."""
        sizes = tuple(body.expansion.getSizes()[1] for body in self.bodies.values())
        return {name: Embedding(sizes, i, self.comm) for i, name in enumerate(self.bodies)}

    def square(self, body: str, matrix: Mat) -> Mat:
        """A matrix of one body as one of all unknowns."""
        return self.among[body].square(matrix)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """K of each body, M, C and Y, and the sparse part of what rotates with it."""
        rotating = (term for each in self.rotating.values() for term in each.pieces[0])
        return (*self._of_each(), *rotating)

    def _of_each(self) -> Iterator[Term]:
        for name, body in self.bodies.items():
            path, motion, square = f"bodies.{name}", self.motion(name), self.among[name].square
            yield from body_terms(path, body, motion, square, with_mass=self.with_mass)

    @property
    def circulatory(self) -> tuple[CirculatoryTerm, ...]:
        """What damping that rotates with its body makes of displacements, but for sparse terms."""
        return tuple(term for each in self.rotating.values() for term in each.pieces[1])

    @cached_property
    def modal_terms(self) -> tuple[LowRankTerm, ...]:
        """Modal damping of each body."""
        return tuple(self._of_modes()) if self.with_mass else ()

    def _of_modes(self) -> Iterator[LowRankTerm]:
        if not self._damped_modes:
            return
        from cea.system.modal_damping import modal_term

        for name, modes in self._damped_modes.items():
            modal, first = self.motion(name).modal, self.among[name].first
            assert modal is not None
            yield modal_term(f"bodies.{name}", self.bodies[name], modal, modes, first)

    def parameters(self) -> Iterator[Parameter]:
        """Parameters of each body."""
        for name, body in self.bodies.items():
            motion = self.motion(name)
            yield from body_parameters(f"bodies.{name}", body, motion, with_mass=self.with_mass)

    def motion(self, body: str) -> Motion:
        """Damping and rotation of a body; of none where it is still."""
        return self.motions.get(body, STILL)

    @cached_property
    def _damped_modes(self) -> dict[str, "DampedModes"]:
        """Modes that are damped one by one, of each body that has any."""
        modal = {name: each for name in self.bodies if (each := self.motion(name).modal)}
        if not modal:
            return {}
        from cea.system.modal_damping import damped_modes

        return {
            name: damped_modes(f"bodies.{name}", self.bodies[name], each)
            for name, each in modal.items()
        }

    @cached_property
    def rotating(self) -> dict[str, "RotatingDamping"]:
        """Damping that rotates with its body, of each body that has any."""
        rotating = [name for name in self.bodies if self.motion(name).circulates]
        if not rotating:
            return {}
        from cea.system.rotating_damping import RotatingDamping

        return {
            name: RotatingDamping(
                f"bodies.{name}",
                self.bodies[name],
                self.motion(name),
                self._damped_modes.get(name),
                self.among[name],
            )
            for name in rotating
        }
