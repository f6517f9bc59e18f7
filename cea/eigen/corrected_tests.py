"""Where friction can move eigenvalues under stiff contact: a bound by corrected test functions.

An eigenpair has y^H (K - kappa M) x = 0 for any y, also for y = x + N z(x), with z displacements
along the normals N of contact nodes that balance friction. Of each x they have the least

    s z^T K z + e^T C e,     C e = L (x + N z) - J x,

C the compliance of contacts, L and J as in :mod:`cea.eigen.multipliers`, K the stiffness of the
bodies: z vanishes where contact is soft, and where it is stiff L (x + N z) = J x, but for what
would take large z, the fewer the larger s. For penalties P K_n = J^T C^-1 J, and e is eliminated.
So (z, e) = Q^-1 W x with Q symmetric; both are kept among the unknowns, with the constraint
W x = Q (z, e) and its multipliers. Each pair adds a negative eigenvalue, and the inertia of the
whole tells of x. Contact forces f that are unknowns, J x = C f, add f^T C f + e^T J x to y^T K x.

With h, g the parts of y^H K x and y^H M x that the symmetric parts of these forms make, and i n
that of the skew part of the second, h = g Re kappa - n Im kappa. Where h >= -X g, g > 0 and
abs(n) <= tau g for every x, every eigenvalue lies in the wedge

    Re kappa >= -X - tau abs(Im kappa).

With z = 0 that is the bound of Bendixson, and X grows with the stiffness of a contact; here it does
not. In the window abs(Im kappa) <= 2 omega sqrt(omega^2 - Re kappa). There r = -Re kappa obeys
r - 2 tau omega sqrt(omega^2 + r) <= X, of which the left side rises with r from where
omega^2 + r = tau^2 omega^2: no eigenvalue of the window lies left of Re kappa = -Y with

    X = Y - 2 tau omega sqrt(omega^2 + Y),     tau^2 omega^2 <= omega^2 + Y.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.eigen.blocks import image_of, times, transposed_times
from cea.eigen.field_of_values import SAFETY, largest_quotient
from cea.eigen.mumps import Mumps, inertia
from cea.eigen.pencil import Matrices
from cea.eigen.regions import TIP
from cea.matrices import (
    destroy,
    distributed,
    largest_row,
    local_part,
    one_below_the_other,
    scaled_total,
    symmetrised,
    transposed_product,
)
from cea.nodes import Nodes
from cea.petsc import MPI, Mat, PETSc

_TOUCHED = 1e-10
"""Trace of a node's block of a contact, relative to the largest, from which it is touched."""
_WEIGHTS = (1.0, 1e2, 1e4)
"""Weights s that are tried, until the mass is positive definite in the test functions."""
_STEPS = 12
"""Steps of block Krylov. From random vectors k steps leave about 0.1 (ln(n) / k)^2 of an extreme
eigenvalue however close others are (Kuczynski, Wozniakowski, SIAM J. Matrix Anal. Appl. 13, 1992):
the safety covers it."""
_DIFFERENT: Any = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN


@dataclass(frozen=True)
class CorrectedTests:
    """Test functions x + N z(x) of a pencil with friction.

    With N (``normals``), Q (``inner``), W (``outer``), and tau (``slope``).
    """

    matrices: Matrices
    normals: Mat
    inner: Mat
    outer: Mat
    slope: float

    @classmethod
    def of(cls, matrices: Matrices) -> Self | None:
        """Those of a pencil at given parameters; collective.

        None without friction, where it is not known which unknowns belong together, where closures
        depend on each other, or where the mass has no positive definite symmetric part;
        ConvergenceError when a factorisation fails.
        """
        forces, nodes = matrices.multipliers, matrices.nodes
        if nodes is None or matrices.symmetric or (forces is not None and forces.dependent):
            return None
        normals = _normals(matrices, nodes)
        for weight in _WEIGHTS:
            inner, outer = _of_penalties(matrices, normals, weight)
            if forces is not None:
                across = forces.reaction.matMult(normals)
                back = across.transpose(PETSc.Mat())
                rest = scaled_total([(1.0, forces.closure), (-1.0, forces.reaction)])
                corner = scaled_total([(-1.0, forces.compliance)])
                made = [across, rest, corner, back, inner, outer]
                nest = PETSc.Mat().createNest([[inner, back], [across, corner]])
                inner, outer = nest.convert("aij"), one_below_the_other([outer, rest])
                destroy(*made)
            tests = cls(matrices, normals, inner, outer, np.inf)
            if (slope := tests._skewness()) is not None:
                return replace(tests, slope=slope)
            destroy(inner, outer)
        destroy(normals)
        return None

    def bounds(self, top: float, depth: float) -> bool:
        """Whether no eigenvalue of a window to top = omega^2 has Re kappa < -depth; collective."""
        within = self.depth_within(top, depth)
        return within is not None and self.holds(within)

    def depth_within(self, top: float, depth: float) -> float | None:
        """X of a wedge that the window leaves at a depth Y (1/s^2); None where there is none."""
        tip, square = TIP * top, self.slope**2
        within = depth - 2 * np.sqrt(square * tip * (tip + depth))
        return float(within) if within >= 0 and square * tip <= tip + depth else None

    def holds(self, within: float) -> bool:
        """Whether h >= -X g for every x; collective."""
        operator = self.matrices.operator(-within)
        whole = self._form(operator, with_forces=True)
        destroy(operator)
        forces = self.matrices.multipliers
        expected = int(self.inner.getSize()[0]) + (0 if forces is None else forces.size)
        return inertia(whole) == (expected, 0)

    def _form(self, matrix: Mat, *, with_forces: bool = False) -> Mat:
        """Symmetric part of x, y -> y^T A x, PETSc AIJ on (x, z, e, multipliers, f).

        (z, e)^T (Q (z, e) - W x) is added, which is zero where the constraints hold: none of the
        pivots of z is zero then, and ranks find them all.
        """
        form = symmetrised(matrix.copy())
        across = transposed_product(self.normals, matrix)
        forces = self.matrices.multipliers
        if forces is not None:
            normal, below = across, forces.closure.copy()
            if not with_forces:
                below.zeroEntries()
            across = one_below_the_other([normal, below])
            destroy(normal, below)
        factor = largest_row(form) / largest_row(self.inner)
        outer, inner = (scaled_total([(factor, each)]) for each in (self.outer, self.inner))
        across.axpy(-factor, self.outer, structure=_DIFFERENT)
        across.scale(0.5)
        against = scaled_total([(-1.0, inner)])
        made = [form, across, outer, inner, against]
        back = [each.transpose(PETSc.Mat()) for each in (across, outer)]
        blocks = [[form, *back], [across, inner, against], [outer, against, None]]
        if with_forces and forces is not None:
            pushed = forces.closure.transpose(PETSc.Mat())
            corner = scaled_total([(-1.0, forces.compliance)])
            made += [pushed, corner]
            blocks = [[*blocks[0], pushed], *([*row, None] for row in blocks[1:])]
            blocks.append([forces.closure, None, None, corner])
        whole = PETSc.Mat().createNest(blocks).convert("aij")
        destroy(*made, *back)
        return whole

    def _skewness(self) -> float | None:
        """Estimate of tau, with a safety; None without a positive definite symmetric part."""
        mass, normals, outer = self.matrices.mass, self.normals, self.outer
        factors = Mumps(self._form(mass), symmetric=True, inertia=True)
        if factors.inertia() != (self.inner.getSize()[0], 0):
            factors.free()
            return None
        rows = mass.getLocalSize()[0]
        inner = Mumps(self.inner.copy(), symmetric=True)

        def solve(load: Floats) -> Floats:
            return factors.solve_block(load)[:rows]

        def half(x: Floats, sign: float) -> Floats:
            """Half of (1 + N Z)^T M x, z = Z x, and of plus or minus its transpose."""
            moved = image_of(mass, x)
            along = transposed_times(normals, moved)
            forward = moved + transposed_times(outer, inner.solve_block(along))
            z = inner.solve_block(times(outer, x))[: len(along)]
            back = image_of(mass, np.asfortranarray(x + times(normals, z)))
            return np.asfortranarray(0.5 * (forward + sign * back))

        skew, image = partial(half, sign=-1.0), partial(half, sign=1.0)
        largest = largest_quotient(solve, skew, rows, mass.comm, _STEPS, image)
        inner.free()
        factors.free()
        return SAFETY * largest if np.isfinite(largest) else None

    def free(self) -> None:
        """Free its matrices."""
        destroy(self.normals, self.inner, self.outer)


def _of_penalties(matrices: Matrices, normals: Mat, weight: float) -> tuple[Mat, Mat]:
    """Stiffness N^T (s K + P K_n) N, and N^T (mu P K_f)^T, new matrices."""
    friction = matrices.unsymmetric if matrices.contacts else None
    contacts = [] if friction is None else [(c * (1.0 - weight), K) for c, K in matrices.contacts]
    weighted = scaled_total([(weight, matrices.stiffness), *contacts])
    along = transposed_product(normals, weighted)
    inner = symmetrised(along.matMult(normals))
    destroy(weighted, along)
    rubbed = normals.copy() if friction is None else friction.matMult(normals)
    rubbed.scale(0.0 if friction is None else -1.0)
    outer = rubbed.transpose(PETSc.Mat())
    destroy(rubbed)
    return inner, outer


def _normals(matrices: Matrices, nodes: Nodes) -> Mat:
    """Unit displacements along normals of the nodes that contacts touch, PETSc AIJ."""
    stiffness = matrices.stiffness
    comm, local = stiffness.comm.tompi4py(), stiffness.getLocalSize()[0]
    along = np.zeros((len(nodes.counts), nodes.dim, nodes.dim))
    touched = np.zeros(len(along), dtype=bool)
    with_friction = matrices.unsymmetric is not None and matrices.contacts
    parts = [scaled_total(matrices.contacts)] if with_friction else []
    if (forces := matrices.multipliers) is not None and not forces.symmetric:
        parts.append(transposed_product(forces.closure, forces.closure))
    for part in parts:
        blocks = nodes.blocks(local_part(part), part.getOwnershipRangeColumn()[0])
        sizes = np.trace(blocks, axis1=1, axis2=2)
        on = sizes > _TOUCHED * comm.allreduce(sizes.max(initial=0.0), MPI.MAX)
        along[on] += blocks[on] / sizes[on, None, None]
        touched |= on
        destroy(part)
    at = np.flatnonzero(touched)
    counts = comm.allgather(len(at))
    unknowns, normals = nodes.unknowns[at], np.linalg.eigh(along[at])[1][:, :, -1]
    column = np.broadcast_to(np.arange(len(at))[:, None], unknowns.shape)
    kept = unknowns >= 0
    entries = (normals[kept], (unknowns[kept], column[kept] + sum(counts[: comm.rank])))
    rows = csr_array(entries, shape=(local, sum(counts)))
    return distributed(rows, (len(at), sum(counts)), stiffness.comm)
