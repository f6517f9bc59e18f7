"""Study beside Figures 4 to 6: what lumping adds to the contact, and what that does to modes.

Lumping replaces sum_ij N_i N_j u_i u_j by sum_i N_i u_i^2 on each side. What it adds is the spread
of the displacements of overlapping functions: nothing for translations, but energy for every
motion that both sides share and that is not constant, rotations first. To first order this moves
an eigenvalue kappa by x^H (K_lumped - K_n) x of the mode x without lumping.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import tau
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.blocks import times
from cea.matrices import destroy
from cea.surface import Surface
from comparisons.kit.plots import AXIS
from comparisons.kit.progress import Progress
from comparisons.kit.tables import Column, Table
from comparisons.paper.common.families import FAMILIES, Family
from comparisons.paper.common.figure import Data, Number
from comparisons.paper.common.style import COLOURS, drawing
from comparisons.paper.disc_pad.case import DISC, PAD
from comparisons.paper.disc_pad.figures import GPTS, LUMPED
from comparisons.paper.disc_pad.runs import RUNS, compare_spectra
from scenes import Result
from scenes.spec.body import Backend
from scenes.spec.plain import as_data

_MARKERS = "os^"


@dataclass(frozen=True)
class LumpingStudy:
    """False stiffness of lumped contact, P = 10⁹."""

    name: str = "lumping"
    title: str = "Shifts of frequencies by lumping, and by its false stiffness alone, P = 10⁹"

    def inputs(self, backend: Backend) -> Data:
        """Scenes of both runs on every kind of mesh."""
        return {
            family: [as_data(case.scene(family)) for case in (GPTS, LUMPED)]
            for family in FAMILIES[backend]
        }

    def compute(self, backend: Backend, progress: Progress) -> Data:
        """Run both cases on every kind of mesh."""
        families = {}
        for family in FAMILIES[backend]:
            progress.step(f"{self.name}, {family}")
            families[family] = _compute(family)
        return {"families": families}

    def numbers(self, data: Data) -> list[Number]:
        """Energy of a rotation, and how well the false stiffness explains the shifts."""
        return list(self._numbers(data))

    def _numbers(self, data: Data) -> Iterator[Number]:
        for family, found in data["families"].items():
            for name, what in (("lumped", "with lumping"), ("plain", "without")):
                rotation = f"{family}: rotation of both bodies over that of the pad alone, {what}"
                yield Number(rotation, None, found["rotation"][name])
            shifts, false = (np.array(found[name]) for name in ("shifts", "false_shifts"))
            yield Number(f"{family}: largest shift", None, float(np.abs(shifts).max()))
            explained = f"{family}: part of the shifts that the false stiffness explains"
            yield Number(explained, None, explained_part(shifts, false))

    def note(self, data: Data) -> str:
        """What the numbers mean."""
        return (
            "Energies of rigid rotations about a horizontal axis in K_n: of both bodies together, "
            "which should cost nothing, over that of the pad alone. The part explained is "
            "1 - |shift - false shift|² / |shift|² over all modes; shifts are relative. On whole "
            "quadratic facets of Lagrange elements lumping is Simpson's rule at the nodes, exact "
            "for squares of rotations; coefficients of NURBS are no values at points."
        )

    def draw(self, data: Data, stem: Path) -> list[Path]:
        """Draw the shifts of all modes over those by the false stiffness."""
        file = stem.with_suffix(".png")
        with drawing(file, (6.0, 4.5)) as figure:
            axes = figure.subplots()
            for i, (family, found) in enumerate(data["families"].items()):
                axes.plot(
                    100 * np.array(found["false_shifts"]),
                    100 * np.array(found["shifts"]),
                    _MARKERS[i],
                    color=COLOURS[i],
                    markersize=4,
                    label=family,
                )
            axes.axline((0, 0), slope=1, color=AXIS, linewidth=0.7)
            axes.set(xlabel="shift by the false stiffness, first order (%)")
            axes.set(ylabel="shift by lumping (%)", title=self.title)
            axes.grid(visible=True)
            axes.legend()
        return [file]

    def tables(self, data: Data, stem: str) -> list[Table]:
        """Shifts of all modes."""
        rows = [
            (family, *row)
            for family, found in data["families"].items()
            for row in zip(*(found[n] for n in _COLUMNS), strict=True)
        ]
        columns = tuple(Column(name, name) for name in ("mesh", *_COLUMNS))
        return [Table(f"{stem}_shifts", self.title, columns, rows)]


_COLUMNS = ("frequency", "shifts", "false_shifts")


def explained_part(shifts: Floats, explained: Floats) -> float:
    """1 - |shifts - explained|^2 / |shifts|^2."""
    return float(1 - np.sum((shifts - explained) ** 2) / np.sum(shifts**2))


def _compute(family: Family) -> Data:
    plain, lumped = (RUNS.result(case, family) for case in (GPTS, LUMPED))
    spectra = [RUNS.spectrum(case, family) for case in (LUMPED, GPTS)]
    false = false_shifts(plain, lumped)
    frequency, shifts, expected = [], [], []
    for group in compare_spectra(*spectra)["groups"]:
        (_, omega), (_, reference) = group["lambda"]
        frequency.append(reference / tau)
        shifts.append(omega / reference - 1)
        expected.append(float(false[group["modes"][1]].mean()))
    return {
        "frequency": frequency,
        "shifts": shifts,
        "false_shifts": expected,
        "rotation": {"plain": rotation_ratio(plain), "lumped": rotation_ratio(lumped)},
    }


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


LUMPING = LumpingStudy()
"""The study."""
