"""A contact: points of one side paired with the other, its law, and its matrices.

    points:   K_n = G^T D G,      K_f = T^T diag(mu) D G,    D = diag(w p)
    mortar:   K_n = B^T M^-1 B,   K_f = B_k^T M^-1 B         (:mod:`cea.contact.mortar`)

A nonlinear law depends on the closure g = G x - g_n: with its pressure sigma(g) and slope p, the
forces against the motion are (G - mu T)^T w sigma, and K_n - K_f is their derivative.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.body import Body, system_operator
from cea.contact.formulations import Coupling, Form
from cea.contact.interface import Interface, along
from cea.contact.mortar import Eliminated, mortar_compliance, mortar_pressure, traces_at
from cea.contact.pressure_and_friction import Friction, NormalLaw, Sliding
from cea.errors import InputError
from cea.matrices import (
    applied,
    block_diagonal,
    destroy,
    one_below_the_other,
    product,
    scaled_total,
    symmetric_product,
    symmetrised,
)
from cea.petsc import PETSc
from cea.ranks import agreed

type Powers = dict[str, tuple[float, float]]
"""Reference and exponent by parameter (:class:`cea.eigen.coefficients.Coefficient`)."""


@dataclass(frozen=True, eq=False)
class Contact:
    """A half pass: points of side a paired with side b, law, friction, and operators."""

    name: str
    pair: str  # name of the contact; both halves of a full pass share it
    a: str  # names of the two bodies
    b: str
    interface: Interface  # its points, on side a
    law: NormalLaw  # law of the normal pressure
    friction: Friction | None = None  # Coulomb friction of steady sliding, or None
    coupling: Coupling = "pointwise"  # treatment of the gaps at the points
    # penalty or saddle form; None: chosen by the digits that the penalty would lose
    form: Form | None = None
    # added to the distance of the sides (m), at all points, (n,); a linear law assumes zero gap
    added_gap: Floats | float = 0.0
    sliding: Sliding | None = None  # effect of sliding on small velocities, or None
    # closures at all points in the linearisation state (m), (n,); None for a linear law
    closure: Floats | None = None
    # G and diag(mu) T, PETSc AIJ (points x unknowns), or B and B_k (multipliers x unknowns) if
    # projected; slip is None without friction. :func:`assembled` sets all fields below
    gap: Any = None
    slip: Any | None = None
    traces: Any | None = None  # psi at the points if gaps are projected, PETSc AIJ, or None
    lumped: tuple[Any, Any | None] | None = None  # K_n and K_f of lumped contact, or None
    # whether slip operators have unit friction because the coefficient is zero
    of_unit_friction: bool = False
    # closure at all points by prescribed displacements (m), (n,), or None
    prescribed: Floats | None = None

    @cached_property
    def slope(self) -> Floats:
        """Contact stiffness p at all points (N/m^3), shape (n,)."""
        points = len(self.interface.points)
        return self.law.slope(np.zeros(points) if self.closure is None else self.closure)

    @property
    def P(self) -> float:
        """Global contact stiffness, the integral of p (N/m)."""
        return float(self.interface.points.weight @ self.slope)

    @property
    def tied(self) -> bool:
        """Whether the contact stiffness is infinite."""
        return bool(np.isinf(self.slope).any())

    @property
    def awaits_state(self) -> bool:
        """Whether the stiffness depends on a steady sliding state that is not yet known."""
        return not self.law.linear and self.closure is None

    @property
    def is_projected(self) -> bool:
        """Whether gaps are projected on the traces of side a."""
        return self.coupling in ("mortar", "bonded")

    @property
    def penalty_only(self) -> bool:
        """Whether the saddle form is impossible: lumped, or a nonlinear law of projected gaps."""
        return self.coupling == "lumped" or (self.is_projected and not self.law.linear)

    @property
    def has_multipliers(self) -> bool:
        """Whether the contact forces are Lagrange multipliers, unknowns of the system."""
        return not self.penalty_only and (self.is_projected or self.form == "saddle")

    @property
    def has_pressure(self) -> bool:
        """Whether gaps determine the contact pressure: the sides are neither tied nor bonded."""
        return self.coupling != "bonded" and not self.tied

    @property
    def has_friction(self) -> bool:
        """Whether the friction coefficient is nonzero anywhere."""
        return self.friction is not None and bool(np.any(self.friction.mu))

    @property
    def mu(self) -> float:
        """Reference friction coefficient of the slip operator; 1 if it varies."""
        mu = np.asarray(self.friction.mu if self.friction is not None else 0.0)
        return 1.0 if self.of_unit_friction or np.ptp(mu) else float(mu.flat[0])

    @property
    def mu_at_points(self) -> Floats:
        """Friction coefficient in the slip operator, at the points of this rank."""
        assert self.friction is not None
        mu = 1.0 if self.of_unit_friction else self.friction.mu
        return np.broadcast_to(mu, len(self.interface.points))[self.interface.rows]

    def friction_direction(self) -> Floats:
        """Return direction k at the points of this rank, shape (n_local, dim); collective."""
        assert self.friction is not None
        points = self.interface.local_points
        try:
            with agreed(self.interface.comm):
                return self.friction.along(points.x, points.normal)
        except InputError as error:
            field = f"contacts.{self.pair}.{error.field}"
            raise InputError(field, error.value, error.allowed) from None

    @property
    def initial_gap(self) -> Floats:
        """Initial gap g_n at all points (m), the added gap included, shape (n,); collective."""
        distance = np.concatenate(self.interface.comm.allgather(self.interface.initial_gap))
        return distance + self.added_gap

    @property
    def K_n(self) -> Any:
        """Normal stiffness (N/m), PETSc AIJ, symmetric semidefinite; dense if projected."""
        return self._matrices[0]

    @property
    def K_f(self) -> Any | None:
        """Friction stiffness (N/m), PETSc AIJ, unsymmetric; None without friction."""
        return self._matrices[1]

    @cached_property
    def _matrices(self) -> tuple[Any, Any | None]:
        if self.lumped is not None:
            return self.lumped
        if self.traces is None or not self.law.linear:
            return self.tangent(self.slope)
        return self._eliminated.matrices()

    def tangent(self, p: Floats) -> tuple[Any, Any | None]:
        """Return K_n and K_f for a slope p at all points (N/m^3); not for lumped contact."""
        if self.traces is not None:
            return self._eliminated.tangent(p)
        weight = self.weight(p)
        friction = product(self.slip, self.gap, weight) if self.slip is not None else None
        return symmetric_product(self.gap, weight), friction

    def closing(self, x: Floats) -> Floats:
        """Return the closure of the gap at all points (m) by unknowns x, (n,), as the law uses it.

        ``x`` (m) are the rows of this rank.
        """
        return self._gaps(x) if self.traces is None else self._eliminated.closing(x)

    def _gaps(self, x: Floats) -> Floats:
        """Return G x, or B x, on every rank."""
        return np.concatenate(self.interface.comm.allgather(applied(self.gap, x)))

    def projected_gap(self, gap: Floats) -> Floats:
        """Return a gap at all points (m) as the law uses it: projected for mortar contact."""
        return gap if self.traces is None else self._eliminated.projected(gap)

    def force(self, pressure: Floats, *, friction: bool = True) -> Floats:
        """Return the forces (N) of a pressure at all points, against the motion; this rank's rows.

        ``friction`` tells whether to include friction forces.
        """
        friction = friction and self.has_friction
        if self.traces is not None:
            return self._eliminated.pushed(pressure, friction=friction)
        weighted = self.weight(pressure)
        force = applied(self.gap, weighted, transposed=True)
        if friction and self.slip is not None:
            force -= applied(self.slip, weighted, transposed=True)
        return force

    def pressure(self, x: Any) -> Floats:
        """Return the contact pressure (N/m^2) at all points, on every rank, for unknowns x (PETSc).

        It is computed from gaps, which lose digits as the stiffness grows. Raise InputError if the
        sides are tied or bonded. For a nonlinear law it is the linearised change of the pressure.
        """
        if not self.has_pressure:
            raise InputError(self.name, self.P, "a finite stiffness, and sides that are not bonded")
        if self.traces is None or not self.law.linear:
            return self.slope * self.closing(x.array_r)
        compliance = self.compliance(self.slope)
        pressure = mortar_pressure(self.traces, compliance, self._gaps(x.array_r))
        destroy(compliance)
        return pressure

    @cached_property
    def _eliminated(self) -> Eliminated:
        """M^-1 between B and B_k, with p = 1 for a nonlinear law."""
        weight = self.interface.points.weight
        compliance = self.compliance(self.slope if self.law.linear else np.ones(len(weight)))
        made = Eliminated(self.traces, weight, compliance, self.gap, self.slip)
        destroy(compliance)
        return made

    def jumps(self, direction: Floats) -> dict[str, csr_array]:
        """Return the jump along directions at this rank's points by body, on its full dofs."""
        on_a = along(self.interface.trace_a, direction)
        return {self.a: on_a, self.b: along(self.interface.trace_b, -direction)}

    def weight(self, values: Floats) -> Floats:
        """Return area weights times values, for values at all points; rows of this rank."""
        return self.interface.local_points.weight * values[self.interface.rows]

    def compliance(self, p: Floats) -> Any:
        """Return M of projected gaps, PETSc AIJ, for a stiffness p at all points (N/m^3)."""
        one = mortar_compliance(self.interface, self.traces, p)
        if self.coupling != "bonded":
            return one
        every = block_diagonal([one] * self.interface.a.dim).convert("aij")
        destroy(one)
        return every


def by_pair(contacts: Sequence[Contact]) -> dict[str, list[Contact]]:
    """Group half passes by the name of their contact."""
    pairs: dict[str, list[Contact]] = {}
    for contact in contacts:
        pairs.setdefault(contact.pair, []).append(contact)
    return pairs


def powers_of(halves: Sequence[Contact]) -> tuple[Powers, Powers]:
    """Return the dependence of the contact stiffness on P, and of friction on mu.

    A nonlinear law has no P; mu is relative to 1 if the halves differ.
    """
    path, values = f"contacts.{halves[0].pair}", {half.mu for half in halves}
    P = {f"{path}.P": (sum(half.P for half in halves), 1.0)} if halves[0].law.linear else {}
    return P, {f"{path}.mu": (values.pop() if len(values) == 1 else 1.0, 1.0)}


def assembled(
    bodies: Mapping[str, Body], contact: Contact, *, frictional: bool, leave_out: bool
) -> Contact:
    """Return a contact with its operators on the unknowns of all bodies; collective.

    ``frictional`` tells whether either half of the contact has friction; if not, ``leave_out``
    omits the slip operator.
    """
    if contact.friction is not None and not frictional:
        contact = replace(contact, of_unit_friction=True)
    interface, points = contact.interface, contact.interface.local_points
    bonded, psi = contact.coupling == "bonded", None
    if contact.is_projected:
        # Open points of a linear law are not projected: their compliance is infinite.
        bearing = (contact.slope > 0) | (not contact.law.linear)
        # Bonded sides constrain the jump along fixed axes, so traces are not split at corners.
        traces = interface.trace_a if bonded else interface.a.split_trace(points.at)
        psi = traces_at(interface, traces, bearing)

    def operator(direction: Floats) -> Any:
        jump = jump_operator(bodies, contact, direction)
        if psi is None:
            return jump
        integrals = product(psi, jump, points.weight)
        destroy(jump)
        return integrals

    if bonded:
        axes = [operator(np.tile(axis, (len(points), 1))) for axis in np.eye(interface.a.dim)]
        gap = one_below_the_other(axes)
        destroy(*axes)
    else:
        gap = operator(points.normal)
    pushed = slip = lumped = prescribed = None
    if contact.friction is not None and not bonded and (frictional or not leave_out):
        pushed = contact.mu_at_points[:, None] * contact.friction_direction()
        slip = operator(pushed)
    if contact.coupling == "lumped":
        lumped = _lumped_matrices(bodies, contact, pushed)
    moved = {
        name: np.concatenate(bodies[name].comm.allgather(own))
        for name in (contact.a, contact.b)
        if (own := bodies[name].prescribed) is not None
    }
    if moved and (closed := approach_along(contact, points.normal, moved)).any():
        prescribed = closed
    made = {"gap": gap, "slip": slip, "traces": psi, "lumped": lumped}
    return replace(contact, **made, prescribed=prescribed)


def jump_operator(bodies: Mapping[str, Body], contact: Contact, direction: Floats) -> Any:
    """Return the jump along directions at this rank's points, PETSc AIJ (points x unknowns)."""
    return system_operator(bodies, contact.jumps(direction), len(direction))


def approach_along(
    contact: Contact, direction: Floats, displacements: Mapping[str, Floats]
) -> Floats:
    """Return the closure along directions at all points (m) by full displacements (m)."""
    jumps = contact.jumps(direction).items()
    parts = [jump @ displacements[name] for name, jump in jumps if name in displacements]
    return np.concatenate(contact.interface.comm.allgather(sum(parts, np.zeros(len(direction)))))


def _lumped_matrices(
    bodies: Mapping[str, Body], contact: Contact, pushed: Floats | None
) -> tuple[Any, Any | None]:
    """Return K_n and K_f of lumped contact on the unknowns of the system; ``pushed`` is mu k.

    The diagonal blocks are lumped: Mohanasundaram et al. (2023), eq. 41. In the block a-a each
    scalar row i sums over the scalar columns j, which leaves a dim x dim block
    sum_q w p N_i(x_q) n n^T, and sum_q mu w p N_i k n^T in K_f; likewise b-b. The blocks a-b stay
    consistent. This is not of the form G^T D G: common translations of both bodies still cause no
    forces, common rotations do.
    """
    normal = contact.interface.local_points.normal
    stiffness = symmetrised(_lumped(bodies, contact, normal))
    stiffness.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return stiffness, None if pushed is None else _lumped(bodies, contact, pushed)


def _lumped(bodies: Mapping[str, Body], contact: Contact, left: Floats) -> Any:
    """Return the product of the jumps along ``left`` and the normals with lumped diagonal blocks.

    In a diagonal block every trace value N_i(x_q) becomes a separate point with the weight
    w p N_i(x_q), at which function i alone is one.
    """
    interface, weight, parts = contact.interface, contact.weight(contact.slope), []
    normal = interface.local_points.normal

    def add(test: Mapping[str, csr_array], trial: Mapping[str, csr_array], weight: Floats) -> None:
        tested, tried = (system_operator(bodies, each, len(weight)) for each in (test, trial))
        parts.append(product(tested, tried, weight))
        destroy(tested, tried)

    tests, trials = contact.jumps(left), contact.jumps(normal)
    for one, other in ((contact.a, contact.b), (contact.b, contact.a)):
        add({one: tests[one]}, {other: trials[other]}, weight)
    for side, trace in ((contact.a, interface.trace_a), (contact.b, interface.trace_b)):
        point, count = np.repeat(np.arange(len(weight)), np.diff(trace.indptr)), trace.nnz
        entries = (np.ones(count), trace.indices, np.arange(count + 1))
        alone = csr_array(entries, shape=(count, trace.shape[1]))
        test, trial = along(alone, left[point]), along(alone, normal[point])
        add({side: test}, {side: trial}, weight[point] * trace.data)
    result = scaled_total([(1.0, part) for part in parts])
    destroy(*parts)
    return result
