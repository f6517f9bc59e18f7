"""Coupled matrices of bodies in frictional contact, kept apart until a solver sums them.

    (lambda^2 M + K + K_n - K_f) x = 0,   K_n = G^T D G,   K_f = T^T diag(mu) D G,   D = diag(w p)

On every rank the unknowns are the free dofs of the first body, then those of the second, and so on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_array

from cea.body import Body, Floats
from cea.constraints import symmetrised
from cea.errors import InputError
from cea.friction import FrictionDirection
from cea.interface import Interface, PointRule, free_operator
from cea.mortar import MortarProjection
from cea.ranks import agreed


@dataclass(frozen=True)
class ContactLaw:
    """Contact stiffness and friction of an interface.

    Parameters
    ----------
    stiffness
        Contact stiffness p at all points of the interface (N/m^3), shape (n,) or one number.
    mu
        Friction coefficient there, shape (n,) or one number; 0 without friction.
    direction
        Direction of the friction traction on side a; needed when mu is not zero.
    projected
        Whether the gap is projected on the traces of side a (mortar).
    """

    stiffness: Floats | float
    mu: Floats | float = 0.0
    direction: FrictionDirection | None = None
    projected: bool = False

    def __post_init__(self) -> None:
        if (np.asarray(self.stiffness) <= 0).any():
            raise InputError("p", self.stiffness, "positive (N/m^3)")
        if (np.asarray(self.mu) < 0).any():
            raise InputError("mu", self.mu, "zero or positive")
        if self.frictional and self.direction is None:
            raise InputError("friction_direction_on_a", None, "needed when mu is not zero")

    @property
    def frictional(self) -> bool:
        """True where there is any friction."""
        return bool(np.any(np.asarray(self.mu) != 0))


@dataclass(frozen=True)
class Contact:
    """Contact matrices of one interface in the unknowns of the whole system.

    Parameters
    ----------
    name
        Name of the contact.
    body_a, body_b
        Names of the bodies on its two sides.
    interface
        Its points.
    rule
        What makes rows of G of them: the points themselves, or multipliers.
    gap
        G, PETSc AIJ (rows x free dofs).
    slip
        diag(mu) T, PETSc AIJ (rows x free dofs), None without friction.
    stiffness
        K_n, PETSc AIJ, symmetric positive semidefinite (N/m).
    friction
        K_f, PETSc AIJ, unsymmetric (N/m), None without friction.
    weight
        Diagonal of D, PETSc vector (rows).
    """

    name: str
    body_a: str
    body_b: str
    interface: Interface
    rule: PointRule | MortarProjection
    gap: Any
    slip: Any | None
    stiffness: Any
    friction: Any | None
    weight: Any

    def pressure(self, x: Any) -> Floats:
        """Contact pressure (N/m^2) at every point, on every rank, for unknowns x."""
        closed = self.gap.createVecLeft()
        self.gap.mult(x, closed)
        pressure = self.rule.pressure(gather(closed))
        closed.destroy()
        return pressure


@dataclass(frozen=True)
class CoupledSystem:
    """Matrices of all bodies and contacts.

    Parameters
    ----------
    bodies
        Bodies by name, in the order of the unknowns.
    stiffness
        K of all bodies, PETSc AIJ (N/m).
    mass
        M of all bodies, PETSc AIJ (kg), None in static scenes.
    load
        Forces (N), PETSc vector, None where no body has any.
    contacts
        Contact matrices.
    index_sets
        Unknowns of each body, PETSc index sets by name.
    """

    bodies: Mapping[str, Body]
    stiffness: Any
    mass: Any | None
    load: Any | None
    contacts: tuple[Contact, ...]
    index_sets: Mapping[str, Any]

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.stiffness.getSize()[0])

    def symmetric_stiffness(self) -> Any:
        """K + K_n, a new PETSc AIJ matrix."""
        return _sum([self.stiffness, *(c.stiffness for c in self.contacts)])

    def friction(self) -> Any | None:
        """K_f of all contacts, None without friction."""
        parts = [c.friction for c in self.contacts if c.friction is not None]
        return _sum(parts) if parts else None

    def displacement(self, x: Any, body: str, *, everywhere: bool = True) -> Floats:
        """Full displacement (m) of one body, shape (dim * num_scalar_dofs,).

        Parameters
        ----------
        x
            Unknowns, PETSc vector.
        body
            Name of the body.
        everywhere
            Whether every rank gets it; otherwise rank 0 does, and others get an empty array.
        """
        part = x.getSubVector(self.index_sets[body])
        full = self.bodies[body].expansion.createVecLeft()
        self.bodies[body].expansion.mult(part, full)
        x.restoreSubVector(self.index_sets[body], part)
        displacement = gather(full, everywhere=everywhere)
        full.destroy()
        return displacement


def couple(
    bodies: Mapping[str, Body],
    contacts: Mapping[str, tuple[str, str, Interface, ContactLaw]],
    *,
    with_mass: bool = True,
    with_load: bool = False,
    leave_out: bool = True,
) -> CoupledSystem:
    """Assemble the coupled matrices.

    Parameters
    ----------
    bodies
        Bodies by name.
    contacts
        By name of the contact: name of body a, name of body b, interface, law.
    with_mass
        Whether the mass is needed.
    with_load
        Whether the loads are needed.
    leave_out
        Whether slip operators and K_f are left out where mu = 0.
    """
    PETSc.garbage_cleanup()  # on several ranks what earlier systems left waits for this call
    nest = _diagonal([body.stiffness() for body in bodies.values()])
    index_sets = dict(zip(bodies, nest.getNestISs()[0], strict=True))
    stiffness = nest.convert("aij")
    mass = _diagonal([b.mass() for b in bodies.values()]).convert("aij") if with_mass else None
    load = None
    if with_load:
        load = stiffness.createVecRight()
        for name, body in bodies.items():
            part = load.getSubVector(index_sets[name])
            body.load().copy(part)
            load.restoreSubVector(index_sets[name], part)
    return CoupledSystem(
        bodies=bodies,
        stiffness=stiffness,
        mass=mass,
        load=load,
        contacts=tuple(
            _contact(bodies, name, *parts, leave_out=leave_out) for name, parts in contacts.items()
        ),
        index_sets=index_sets,
    )


def _contact(
    bodies: Mapping[str, Body],
    name: str,
    a: str,
    b: str,
    interface: Interface,
    law: ContactLaw,
    *,
    leave_out: bool,
) -> Contact:
    points = interface.local_points
    stiffness = np.broadcast_to(np.asarray(law.stiffness, dtype=float), len(interface.points))
    rule = (MortarProjection.of if law.projected else PointRule)(interface, stiffness)
    gap = _system_operator(bodies, a, b, rule.jump(points.normal, np.ones(len(points))))
    weight = gap.createVecLeft()
    weight.array[:] = rule.weight
    slip = friction = None
    if law.direction is not None and (law.frictional or not leave_out):
        with agreed(interface.comm):
            direction = law.direction.at(points.x, points.normal)
        mu = np.broadcast_to(law.mu, len(interface.points))[interface.rows]
        slip = _system_operator(bodies, a, b, rule.jump(direction, mu))
        friction = _product(slip, gap, weight)
    return Contact(
        name=name,
        body_a=a,
        body_b=b,
        interface=interface,
        rule=rule,
        gap=gap,
        slip=slip,
        stiffness=_symmetric_product(gap, weight),
        friction=friction,
        weight=weight,
    )


def _system_operator(
    bodies: Mapping[str, Body], a: str, b: str, jump: tuple[csr_array, csr_array]
) -> Any:
    """Parts of a jump on a and b as one operator on the unknowns of the whole system."""
    parts = dict(zip((a, b), jump, strict=True))
    row = []
    for name, body in bodies.items():
        nothing = csr_array((jump[0].shape[0], body.dim * body.num_scalar_dofs))
        row.append(free_operator(parts.get(name, nothing), body))
    operator = PETSc.Mat().createNest([row]).convert("aij")
    _destroy(*row)
    return operator


def _product(left: Any, right: Any, factor: Any) -> Any:
    """L^T diag(factor) R."""
    scaled = right.copy()
    scaled.diagonalScale(L=factor)
    product = left.transposeMatMult(scaled)
    _destroy(scaled)
    return product


def _symmetric_product(gap: Any, weight: Any) -> Any:
    """G^T D G as (sqrt(D) G)^T (sqrt(D) G): symmetric to the last bit.

    On several ranks an entry and its mirror image may add the same parts in another order; their
    mean does not.
    """
    root = weight.copy()
    root.sqrtabs()
    scaled = gap.copy()
    scaled.diagonalScale(L=root)
    product = scaled.transposeMatMult(scaled)
    if product.comm.size > 1:
        symmetrised(product)
    product.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    _destroy(root, scaled)
    return product


def _destroy(*objects: Any) -> None:
    """Free PETSc objects now: on several ranks Python's collector only puts them aside."""
    for each in objects:
        each.destroy()


def _diagonal(blocks: Sequence[Any]) -> Any:
    n = len(blocks)
    return PETSc.Mat().createNest(
        [[blocks[i] if i == j else None for j in range(n)] for i in range(n)]
    )


def _sum(matrices: Sequence[Any]) -> Any:
    total = matrices[0].copy()
    for matrix in matrices[1:]:
        total.axpy(1.0, matrix, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    return total


def gather(vector: Any, *, everywhere: bool = True) -> Floats:
    """Whole PETSc vector on every rank, or on rank 0 only and empty on others."""
    scatter, whole = (PETSc.Scatter.toAll if everywhere else PETSc.Scatter.toZero)(vector)
    scatter.scatter(vector, whole)
    values = np.array(whole.array)
    _destroy(scatter, whole)
    return values
