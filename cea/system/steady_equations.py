"""Residual and tangent of steady sliding, for Newton's method.

With K the stiffness of all linear parts (bodies, their rotation as far as it acts on displacements
at rest in space, contacts of linear laws with their multipliers f), the load F and the contacts
with a nonlinear law,

    R(x) = K x + L^T f + sum (G - mu T)^T w sigma(g) - t F,     g = G x - g_n

vanishes in steady sliding at load factor t (Mohanasundaram et al., 2023, eqs. 5 and 16).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cea.arrays import Floats
from cea.contact.pressure_and_friction import NormalCompliance
from cea.eigen.pencil import Matrices, Sizes, internal_forces
from cea.eigen.shifted import Shifted, count_below
from cea.eigen.static import rounding_uncertainty
from cea.errors import ConvergenceError
from cea.matrices import destroy, scaled_total
from cea.petsc import MPI, Vec
from cea.system.coupled import CoupledSystem

OPENS = "the load opens the contact: no point is closed"
LEFT_OVER = 1e-8
"""Residual, relative to the load, up to which a state is always accepted."""
LOST = 0.1
"""Rounding error, relative to the largest displacement, above which a tangent is singular."""
_OVERLAP = 1e-9
"""Overlap of the sides, relative to the mesh size, due to rounding and faceting."""

type Slopes = Sequence[Floats]
"""Slope p at all points (N/m^3) of each contact with a law, shape (n,) each."""


@dataclass(frozen=True)
class State:
    """Displacements and contact forces, with their closures and residual."""

    x: Floats  # displacements, the rows of this rank (m)
    f: Floats  # Lagrange multipliers, the rows of this rank (N)
    # closures u_n - g_n at all points of each contact with a law (m), on every rank
    closures: tuple[Floats, ...]
    residual: Floats  # R, the rows of this rank (N)
    norm: float  # its norm over all ranks (N)
    scale: float  # largest of the norms of its terms (N)
    noise: float  # its rounding error due to the closures (N)

    @property
    def relative(self) -> float:
        """Residual relative to the largest of its terms."""
        return self.norm / self.scale if self.scale else 0.0

    @property
    def closed_points(self) -> int:
        """Number of closed points."""
        return sum(int(np.count_nonzero(closure > 0)) for closure in self.closures)


class SteadyEquations:
    """Equations of steady sliding of a coupled system with loads and nonlinear contact laws.

    Pressures and slopes of the laws are divided by ``softness``, a continuation parameter, else 1.
    """

    def __init__(self, system: CoupledSystem) -> None:
        assert system.load is not None
        self.system, self._load, self.softness = system, system.load, 1.0
        self.comm = system.template.comm.tompi4py()
        self.contacts = tuple(c for c in system.contacts if not c.law.linear)
        # The pencil at rest without nonlinear contacts.
        linear = tuple(replace(c, sliding=None) for c in system.contacts if c.law.linear)
        self.matrices = replace(system, contacts=linear).pencil().at_rest().at()
        self._gaps = [contact.projected_gap(contact.initial_gap) for contact in self.contacts]
        self._prescribed = [
            0.0 if contact.prescribed is None else contact.projected_gap(contact.prescribed)
            for contact in self.contacts
        ]
        self.springs: list[Floats] = []  # slopes at all points of each nonlinear contact (N/m^3)
        self._size = system.template.getLocalSize()

    @cached_property
    def unstable(self) -> bool:
        """Whether the rotating bodies have an indefinite stiffness without these contacts.

        If so, there may be several equilibria without friction, or none.
        """
        return self.system.softens and count_below(self.matrices, 0.0) > 0

    @cached_property
    def are_held(self) -> bool:
        """Whether the bodies have no rigid body mode without nonlinear contacts; collective."""
        load = np.random.default_rng(self.comm.rank).standard_normal(self._size)
        return solved_regularly(self.matrices, load) is not None

    def gaps_at(self, factor: float, *, even: bool = False) -> list[Floats]:
        """Return gaps at all points of each nonlinear contact (m) for fixed free dofs.

        Prescribed displacements are scaled by the load factor. ``even`` replaces each gap by the
        smallest one, as for the springs.
        """
        gaps = [np.full(len(gap), gap.min()) for gap in self._gaps] if even else self._gaps
        pairs = zip(gaps, self._prescribed, strict=True)
        return [gap - factor * closed for gap, closed in pairs]

    def state(self, x: Floats, f: Floats, factor: float) -> State:
        """Return the state of displacements (m) and contact forces (N) at a load factor."""
        closings, gaps = [each.closing(x) for each in self.contacts], self.gaps_at(factor)
        closures = tuple(u - gap for u, gap in zip(closings, gaps, strict=True))
        rounding = [
            slope * np.finfo(float).eps * np.maximum(np.abs(u), np.abs(gap))
            for slope, u, gap in zip(self.slopes(closures), closings, gaps, strict=True)
        ]
        elastic = internal_forces(self.matrices, x[:, None], f[:, None])[:, 0]
        contact, load = self.contact_forces(closures), factor * self._load.array_r
        residual = elastic + contact - load
        norm, noise, *sizes = self.norms(residual, self._forces(rounding), load, contact, elastic)
        return State(x, f, closures, residual, float(norm), float(max(sizes)), float(noise))

    def contact_forces(self, closures: Sequence[Floats]) -> Floats:
        """Return the forces of nonlinear contacts at closures (N), the rows of this rank."""
        pairs = zip(self.contacts, closures, strict=True)
        return self._forces([each.law.pressure(g) / self.softness for each, g in pairs])

    def slopes(self, closures: Sequence[Floats]) -> list[Floats]:
        """Return the slopes of the laws at given closures."""
        pairs = zip(self.contacts, closures, strict=True)
        return [each.law.slope(g) / self.softness for each, g in pairs]

    def _forces(self, pressures: Sequence[Floats], *, friction: bool = True) -> Floats:
        """Return the forces of pressures at all points of each contact, the rows of this rank."""
        pairs = zip(self.contacts, pressures, strict=True)
        forces = (contact.force(pressure, friction=friction) for contact, pressure in pairs)
        return sum(forces, np.zeros(self._size))

    def norms(self, *vectors: Floats) -> Floats:
        """Return norms over all ranks of vectors given by the rows of this rank."""
        squares = np.array([float(v @ v) for v in vectors])
        return np.sqrt(self.comm.allreduce(squares, MPI.SUM))

    def tangent(self, slopes: Slopes, *, friction: bool = True) -> Matrices:
        """Return the derivative of R at given slopes; free it with :func:`free_tangent`."""
        made = [each.tangent(p) for each, p in zip(self.contacts, slopes, strict=True)]
        stiffness = scaled_total([(1.0, self.matrices.stiffness), *((1.0, K_n) for K_n, _ in made)])
        stiffness.setOption(stiffness.Option.SYMMETRIC, True)
        rest: list[tuple[float, Any]] = []
        if self.matrices.unsymmetric is not None:
            rest.append((1.0, self.matrices.unsymmetric))
        for contact, (_, K_f) in zip(self.contacts, made, strict=True):
            if friction and contact.has_friction:
                rest.append((-1.0, K_f))
        unsymmetric = scaled_total(rest) if rest else None
        destroy(*(each for pair in made for each in pair if each is not None))
        return replace(self.matrices, stiffness=stiffness, unsymmetric=unsymmetric)

    def take_springs(self, factor: float) -> None:
        """Set springs at all points, with the secant stiffness at the mean pressure of a load.

        They act in tension too, and are stress-free where the smallest initial gap is closed.
        """
        self.springs, force = [], factor * float(self._load.norm(1))
        for contact, gap in zip(self.contacts, self._gaps, strict=True):
            law, interface, nearest = contact.law, contact.interface, float(gap.min())
            assert isinstance(law, NormalCompliance)
            size = min(interface.a.mesh_size, interface.b.mesh_size)
            overlap = -nearest if -nearest > _OVERLAP * size else 0.0
            even = force / float(interface.points.weight.sum())
            closure = np.array(max(law.closure(even), overlap))
            if not closure > 0:
                raise ConvergenceError(f"{OPENS}; nothing presses the sides together", best=None)
            self.springs.append(np.full(len(gap), law.pressure(closure) / closure))

    def forces_at_rest(self, factor: float) -> Floats:
        """Return the load and the spring forces (N) at zero displacement, the rows of this rank."""
        pairs = zip(self.springs, self.gaps_at(factor, even=True), strict=True)
        springs = self._forces([p * rest for p, rest in pairs], friction=False)
        return factor * self._load.array_r + springs

    def spring_resultant(self, x: Floats, factor: float) -> float:
        """Return the sum of the normal forces (N) of the springs, positive in compression."""
        gaps, total = self.gaps_at(factor, even=True), 0.0
        for contact, p, gap in zip(self.contacts, self.springs, gaps, strict=True):
            total += float(contact.interface.points.weight @ (p * (contact.closing(x) - gap)))
        return total

    def checked_residual(self, state: State, tangent: Matrices) -> float:
        """Return the residual at full load relative to the load; raise if too large; collective."""
        contact, load = self.contact_forces(state.closures), self._load.array_r
        norm, of_load, of_contact = self.norms(state.residual, load, contact)
        size = of_load or of_contact or 1.0
        if norm > LEFT_OVER * size:
            sizes = Sizes(tangent)
            forces = sizes.forces(state.x[:, None], state.f[:, None])
            (rounding,) = self.norms(np.finfo(float).eps * forces[:, 0])
            sizes.free()
            if norm > rounding:
                raise ConvergenceError(
                    "the state of steady sliding is not in equilibrium: the residual is "
                    f"{norm / size:.1e} of the load, its rounding error {rounding / size:.1e}",
                    best=state,
                )
        return float(norm / size)

    def vector(self, x: Floats) -> Vec:
        """Return displacements as a new PETSc vector."""
        vector = self.system.vector()
        vector.array[:] = x
        return vector


def free_tangent(tangent: Matrices) -> None:
    """Free a tangent, except the multipliers that it shares."""
    destroy(*(m for m in (tangent.stiffness, tangent.unsymmetric) if m))


def solved(factors: Shifted, b: Floats) -> tuple[Floats, Floats]:
    """Solve for displacements and contact forces for forces b (N), the rows of this rank."""
    x, f = factors.solve_with_forces(b[:, None])
    return x[:, 0], f[:, 0]


def solved_regularly(matrices: Matrices, b: Floats) -> tuple[Floats, Floats] | None:
    """Solve for displacements and contact forces; None if the matrix is numerically singular."""
    try:
        factors = Shifted(matrices)
    except ConvergenceError:
        return None
    x, f = solved(factors, b)
    uncertainty = rounding_uncertainty(matrices, factors, x[:, None], f[:, None])
    factors.free()
    return (x, f) if uncertainty < LOST else None
