"""Forces on sliding bodies at any state, and the tangent there: what Newton's method works on.

With K and K_f of what is linear (bodies with all that their rotation makes of displacements at rest
in space, contacts of known stiffness, their forces f where these are unknowns), the load F and the
contacts whose pressure obeys a law of their closure,

    R(x) = K x + L^T f + sum (G - mu T)^T w sigma(g) - t F,     g = G x - g_n

vanishes in steady sliding at the load factor t (Mohanasundaram et al., 2023, eqs. 5 and 16).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.contact.laws import NormalCompliance
from cea.contact.operators import Contact
from cea.eigen.pencil import Matrices, release
from cea.eigen.residuals import internal_forces
from cea.eigen.shifted import count_below
from cea.matrices import destroy, scaled_total
from cea.petsc import MPI, Vec
from cea.system.coupled import CoupledSystem

Slopes = Sequence[Floats]
"""Slope p at all points (N/m^3) of each contact with a law, shape (n,) each."""


@dataclass(frozen=True)
class State:
    """A state of the bodies and what it meets.

    Parameters
    ----------
    x
        Displacements, the rows of this rank (m).
    f
        Contact forces that are unknowns, the rows of this rank (N).
    closures
        Closures u_n - g_n at all points of each contact with a law (m), on every rank.
    residual
        R, the rows of this rank (N).
    norm
        Its norm over all ranks (N).
    scale
        Size of the forces that it is the sum of (N).
    noise
        What rounding of the closures makes of it (N).
    """

    x: Floats
    f: Floats
    closures: tuple[Floats, ...]
    residual: Floats
    norm: float
    scale: float
    noise: float

    @property
    def relative(self) -> float:
        """Residual relative to the forces it is the sum of."""
        return self.norm / self.scale if self.scale else 0.0


class SlidingProblem:
    """The equations of steady sliding of a coupled system.

    Parameters
    ----------
    system
        The system, with loads; some contact has a law that is not linear.
    friction
        Whether with the friction of contacts that have such a law.

    Attributes
    ----------
    softness
        What pressures and slopes of the laws are divided by; 1 but on the way to a solution.
    """

    def __init__(self, system: CoupledSystem, *, friction: bool = True) -> None:
        self.system = system
        self.softness = 1.0
        self.comm = system.template.comm.tompi4py()
        self.contacts: tuple[Contact, ...] = tuple(
            contact for contact in system.contacts if not contact.half.law.linear
        )
        self.frictional = tuple(friction and _rubs(contact) for contact in self.contacts)
        linear = tuple(contact for contact in system.contacts if contact.half.law.linear)
        self.matrices = replace(system, contacts=linear, sliding={}).pencil().at_rest().at()
        assert system.load is not None
        self._load = system.load
        self._gaps = tuple(contact.reactions.met(initial_gap(contact)) for contact in self.contacts)
        self._prescribed = tuple(
            None if contact.prescribed is None else contact.reactions.met(contact.prescribed)
            for contact in self.contacts
        )
        self._x = system.vector()

    @cached_property
    def unstable(self) -> bool:
        """Whether the stiffness of bodies as they rotate, without these contacts, is indefinite.

        That is so where the rate of a rotation with convective stiffness is beyond a critical
        one; without friction there may then be several equilibria or none.
        """
        return self.system.pieces.softens and count_below(self.matrices, 0.0) > 0

    @property
    def areas(self) -> tuple[float, ...]:
        """Area of each contact (m^2)."""
        return tuple(float(c.interface.points.weight.sum()) for c in self.contacts)

    @property
    def load(self) -> float:
        """Sum of the absolute forces of the load (N)."""
        return float(self._load.norm(1))

    def gaps_at(self, factor: float) -> tuple[Floats, ...]:
        """Gaps at all points of each contact with a law (m) where free dofs do not move.

        Parameters
        ----------
        factor
            The part of the load, and of the displacements that supports prescribe.
        """
        return tuple(
            gap if closed is None else gap - factor * closed
            for gap, closed in zip(self._gaps, self._prescribed, strict=True)
        )

    @property
    def nearest(self) -> tuple[float, ...]:
        """Least initial gap of each contact with a law (m)."""
        return tuple(float(gap.min()) for gap in self._gaps)

    def law(self, number: int) -> NormalCompliance:
        """Law of a contact."""
        law = self.contacts[number].half.law
        assert isinstance(law, NormalCompliance)
        return law

    @property
    def rows(self) -> int:
        """Displacements of this rank."""
        return int(self._x.getLocalSize())

    def zero(self) -> tuple[Floats, Floats]:
        """Displacements and contact forces of bodies at rest."""
        multipliers = self.matrices.multipliers
        forces = 0 if multipliers is None else multipliers.closure.getLocalSize()[0]
        return np.zeros(self.rows), np.zeros(forces)

    def state(self, x: Floats, f: Floats, factor: float) -> State:
        """The state of some displacements and forces under a part of the load.

        Parameters
        ----------
        x, f
            Displacements (m) and contact forces that are unknowns (N), the rows of this rank.
        factor
            The part of the load.
        """
        self._x.array[:] = x
        elastic = internal_forces(self.matrices, x[:, None], f[:, None])[:, 0]
        approaches = [each.reactions.approach(self._x) for each in self.contacts]
        gaps = self.gaps_at(factor)
        closures = tuple(u - gap for u, gap in zip(approaches, gaps, strict=True))
        contact = self.contact_forces(closures)
        rounding = self._reactions(
            [
                slope * np.finfo(float).eps * np.maximum(np.abs(u), np.abs(gap))
                for slope, u, gap in zip(self.slopes(closures), approaches, gaps, strict=True)
            ]
        )
        load = self.load_at(factor)
        residual = elastic + contact - load
        norm, noise, *sizes = self.norms(residual, rounding, load, contact, elastic)
        return State(x, f, closures, residual, float(norm), float(max(sizes)), float(noise))

    def contact_forces(self, closures: Sequence[Floats]) -> Floats:
        """Forces of the contacts with a law at some closures (N), the rows of this rank."""
        pairs = zip(self.contacts, closures, strict=True)
        return self._reactions([c.half.law.pressure(g) / self.softness for c, g in pairs])

    def _reactions(self, pressures: Sequence[Floats]) -> Floats:
        """Forces of pressures at all points of each contact, the rows of this rank."""
        total = np.zeros(self.rows)
        for contact, pressure, rubs in zip(self.contacts, pressures, self.frictional, strict=True):
            force = contact.reactions.forces(pressure, friction=rubs)
            total += force.array_r
            destroy(force)
        return total

    def norms(self, *vectors: Floats) -> Floats:
        """Norms over all ranks of vectors given by the rows of this rank."""
        squares = np.array([float(v @ v) for v in vectors])
        return np.sqrt(self.comm.allreduce(squares, MPI.SUM))

    def slopes(self, closures: Sequence[Floats]) -> tuple[Floats, ...]:
        """Slopes of the laws at given closures."""
        laws = (contact.half.law for contact in self.contacts)
        return tuple(law.slope(g) / self.softness for law, g in zip(laws, closures, strict=True))

    def tangent(self, slopes: Slopes, *, friction: bool = True) -> Matrices:
        """Derivative of R at given slopes; free it with :func:`free_tangent`.

        Parameters
        ----------
        slopes
            Slopes at all points (N/m^3).
        friction
            Whether with the derivative of friction.
        """
        symmetric: list[tuple[float, Any]] = [(1.0, self.matrices.stiffness)]
        rest: list[tuple[float, Any]] = []
        made: list[Any] = []
        if self.matrices.unsymmetric is not None:
            rest.append((1.0, self.matrices.unsymmetric))
        for contact, slope, rubs in zip(self.contacts, slopes, self.frictional, strict=True):
            normal, rubbing = contact.reactions.tangent(slope)
            made += [normal] if rubbing is None else [normal, rubbing]
            symmetric.append((1.0, normal))
            if rubbing is not None and rubs and friction:
                rest.append((-1.0, rubbing))
        stiffness = scaled_total(symmetric)
        stiffness.setOption(stiffness.Option.SYMMETRIC, True)
        unsymmetric = scaled_total(rest) if rest else None
        destroy(*made)
        return replace(self.matrices, stiffness=stiffness, unsymmetric=unsymmetric)

    def load_at(self, factor: float) -> Floats:
        """A part of the load (N), the rows of this rank."""
        return factor * self._load.array_r

    def rest(self, factor: float) -> tuple[Floats, ...]:
        """What closes the least initial gap at all points of each contact with a law (m)."""
        return tuple(
            np.full(len(gap), least) if closed is None else least - factor * closed
            for gap, least, closed in zip(self._gaps, self.nearest, self._prescribed, strict=True)
        )

    def spring_forces(self, slopes: Slopes, factor: float) -> Floats:
        """Forces of springs at all points whose rest is the least gap (N), the rows of this rank.

        Parameters
        ----------
        slopes
            Stiffness of the springs (N/m^3).
        factor
            The part of the load.
        """
        total = np.zeros(self.rows)
        for contact, slope, rest in zip(self.contacts, slopes, self.rest(factor), strict=True):
            force = contact.reactions.forces(slope * rest, friction=False)
            total += force.array_r
            destroy(force)
        return total

    def vector(self, x: Floats) -> Vec:
        """Displacements as a new PETSc vector."""
        vector = self.system.vector()
        vector.array[:] = x
        return vector

    def free(self) -> None:
        """Free what was made for the equations."""
        release(self.matrices)
        destroy(self._x)


def free_tangent(tangent: Matrices) -> None:
    """Free a tangent, not the multipliers it shares."""
    destroy(*(m for m in (tangent.stiffness, tangent.unsymmetric) if m))


def initial_gap(contact: Contact) -> Floats:
    """Initial gap g_n at all points (m), of the geometry with what is added to it, shape (n,)."""
    interface = contact.interface
    distance = np.concatenate(interface.comm.allgather(interface.initial_gap))
    return distance + contact.half.added_gap


def _rubs(contact: Contact) -> bool:
    friction = contact.half.friction
    return contact.slip is not None and friction is not None and friction.acts
