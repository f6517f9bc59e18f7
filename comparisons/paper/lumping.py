"""Study beside Figures 4 to 6: what lumping adds to the contact, and what that does to modes.

Lumping replaces sum_ij N_i N_j u_i u_j by sum_i N_i u_i^2 on each side. What it adds is the spread
of the displacements of overlapping functions: nothing for translations, but energy for every
motion that both sides share and that is not constant, rotations first. To first order this moves
an eigenvalue kappa by x^H (K_lumped - K_n) x of the mode x without lumping.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import tau
from typing import Any

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.blocks import times
from cea.matrices import destroy
from cea.surface import Surface
from comparisons.paper.disc_pad import DISC, GPTS, LUMPED, PAD
from comparisons.paper.figure import Figure, Mesh, Tables, rows_of
from comparisons.paper.spectra import Spectrum, means_of, paired
from comparisons.study.session import Session
from scenes import Result
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class Lumping(Figure):
    """False stiffness of lumped contact, P = 10⁹."""

    def inputs(self, mesh: Mesh) -> Mapping[str, Scene]:
        """Scenes of both runs."""
        return {"plain": GPTS.scene(mesh), "lumped": LUMPED.scene(mesh)}

    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Shifts of all modes, and energies of a rotation."""
        plain, lumped = (session.solve(session.scene[name]) for name in ("plain", "lumped"))
        match = paired(Spectrum.of(lumped), Spectrum.of(plain))
        omega, reference = (values.imag for values in means_of(match))
        shifts, false = omega / reference - 1, false_shifts(plain, lumped)
        expected = np.array([false[pair.second].mean() for pair in match.groups])
        columns = {"frequency": reference / tau, "shift": shifts, "false_shift": expected}
        summary = {
            "rotation_plain": rotation_ratio(plain),
            "rotation_lumped": rotation_ratio(lumped),
            "largest_shift": float(np.abs(shifts).max()),
            "explained": float(1 - np.sum((shifts - expected) ** 2) / np.sum(shifts**2)),
        }
        return {"lumping": [summary], "lumping_shifts": rows_of(columns)}


def false_shifts(plain: Result, lumped: Result) -> Floats:
    """First order relative shifts of all frequencies of a run by what lumping adds, (modes,)."""
    modes = plain.modes
    difference = _stiffness(lumped).copy()
    difference.axpy(-1.0, _stiffness(plain))
    products = np.einsum("ij,ij->j", modes.vectors.conj(), times(difference, modes.vectors)).real
    energies = difference.comm.tompi4py().allreduce(products)
    destroy(difference)
    return energies / (2 * np.abs(modes.eigenvalues) ** 2)


def _stiffness(result: Result) -> Any:
    """K_n, PETSc AIJ (N/m)."""
    return result.system.contacts[0].K_n


def rotation_ratio(result: Result) -> float:
    """Energy of a rotation about the x axis in K_n: of both bodies, over that of the pad alone."""
    contact = result.system.contacts[0]
    sides = {contact.a: contact.interface.a, contact.b: contact.interface.b}
    height = contact.interface.points.x[:, 1].mean()
    energies = []
    for turned in ((PAD, DISC), (PAD,)):
        vector = result.system.vector()
        for name in turned:
            u = _normal_displacement(result.system.bodies[name], sides[name], height)
            part = vector.getSubVector(result.system.index_sets[name])
            u.copy(part)
            vector.restoreSubVector(result.system.index_sets[name], part)
            destroy(u)
        product = vector.duplicate()
        _stiffness(result).mult(vector, product)
        energies.append(vector.dot(product))
        destroy(vector, product)
    return float(energies[0] / energies[1])


def _normal_displacement(body: Body, side: Surface, height: float) -> Any:
    """Free dofs of a body for u_z = y - height on a surface and none elsewhere, PETSc vector."""
    points = side.gauss_points(side.cells().degree + 1)
    trace = side.trace(points.at)
    touched = np.unique(trace.indices)
    values = trace[:, touched]
    gram = csc_array(values.T @ values.multiply(points.weight[:, None]))
    load = values.T @ (points.weight * (points.x[:, 1] - height))
    full = np.zeros((body.num_scalar_dofs, body.dim))
    full[touched, 2] = spsolve(gram, load)
    vector, free = body.expansion.createVecLeft(), body.expansion.createVecRight()
    vector.array[:] = full.ravel()[slice(*vector.getOwnershipRange())]
    body.expansion.multTranspose(vector, free)
    destroy(vector)
    return free


LUMPING = Lumping(
    "lumping", "Shifts of frequencies by lumping, and by its false stiffness alone, P = 10⁹"
)
"""The study."""
