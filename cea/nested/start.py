"""Modes of a coarse mesh as a start space on a finer one.

A few block inverse steps (:mod:`cea.nested.block_steps`) take the place of a search: what is left
is told by residuals, as of any modes. No more modes come out than went in. That none is missing is
not shown: that is known of the mesh on which a window was searched.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.eigenpairs import checked
from cea.eigen.eigenvalue_matching import assign
from cea.eigen.modes import Modes, modes_of
from cea.eigen.pencil import Pencil
from cea.eigen.sensitivity import dual_norms, left_vectors_of
from cea.eigen.spectrum import Window, nearest_window
from cea.errors import InputError
from cea.nested.approximation import Approximation
from cea.nested.block_steps import BlockSteps, middle_shift
from cea.nested.estimate import prolonged
from cea.nested.prolongation import Prolongation
from cea.timing import StageTimer


@dataclass(frozen=True)
class ContinuedWindow(Window):
    """A window whose modes were continued from a coarser mesh: none was searched for."""

    @property
    def complete(self) -> bool:
        """False: the mesh on which modes were searched for tells."""
        return False

    @property
    def evidence(self) -> str:
        """Where the modes come from, in words."""
        return f"{self.found} eigenvalues continued from a coarser mesh; none was searched for"


def continued(
    coarse: Modes,
    pencil: Pencil,
    prolongation: Prolongation,
    max_frequency: float,
    changes: Mapping[str, float] | None = None,
    *,
    steps: int = 2,
    left: bool = False,
    timer: StageTimer | None = None,
) -> Modes:
    """Modes of a pencil that a coarser one has; collective.

    Parameters
    ----------
    coarse
        Modes of the coarser mesh, with left vectors unless they are symmetric.
    pencil
        The pencil of the finer mesh.
    prolongation
        From the coarse displacements to the fine ones.
    max_frequency
        Upper end of the modes that are kept (Hz). Coarse ones beyond it help those below it.
    changes
        Parameters of the pencil that differ from their own values.
    steps
        Block inverse steps. One leaves about a hundredth of the difference of the meshes, where
        they differ at small scale, two a hundredth of that.
    left
        Whether left vectors are wanted too.
    timer
        Counts assembly, factorisation, krylov and post-processing.

    Raises
    ------
    InputError
        When there are no modes or no left vectors, less than one step is asked for, or something
        damps or rotates.
    ConvergenceError
        When the pencil is singular at shifts amid the modes.
    """
    timer, values = timer or StageTimer(), pencil.values(changes)
    if steps < 1:
        raise InputError("steps", steps, "1 or more")
    with timer("assembly"):
        matrices = pencil.at(values)
        if matrices.quadratic:
            raise InputError("damping", True, "none, and no rotation, to continue modes with")
        start = prolonged(coarse, matrices, prolongation)
    with timer("factorisation"):
        work = BlockSteps(matrices, middle_shift(start.eigenvalues))
    try:
        with timer("krylov"):
            found = work.improved(start, steps).approximation
        kappa, found = _in_pairs(found)
        with timer("post-processing"):
            pairs = checked(matrices, work.factors, kappa, found.right)
            left_vectors = None
            if left:
                top = (2 * np.pi * max_frequency) ** 2
                left_vectors = left_vectors_of(
                    matrices, work.factors, pairs, kappa.conj(), found.left, top
                )
                if not matrices.symmetric:
                    conditions = dual_norms(matrices.mass, left_vectors.vectors)
                    pairs = replace(pairs, conditions=conditions)
            window = _window(max_frequency, work.factors.kappa, pairs.kappa)
            return modes_of(pencil, values, matrices, pairs, left_vectors, window)
    finally:
        work.free()


def _window(max_frequency: float, shift: float, kappa: Complexes) -> ContinuedWindow:
    """A window in which nothing was searched."""
    plain = replace(nearest_window(shift, kappa), discs=0)
    given: dict[str, Any] = {field.name: getattr(plain, field.name) for field in fields(plain)}
    return ContinuedWindow(**given | {"max_frequency": max_frequency})


def _in_pairs(modes: Approximation) -> tuple[Complexes, Approximation]:
    """Values kappa and vectors; conjugates follow each other, with conjugate vectors."""
    values = modes.eigenvalues
    oscillating = values.imag > 0
    decays = np.flatnonzero(oscillating & (values.real < 0))
    grows = np.flatnonzero(oscillating & (values.real > 0))
    first, second = assign(np.abs(values[decays][:, None] + values[grows].conj()))
    decays, grows = decays[first], grows[second]
    alone = np.setdiff1d(np.arange(len(values)), np.concatenate([decays, grows]))
    kappa = -(values**2)

    def ordered(vectors: Complexes) -> Complexes:
        twins = np.empty((len(vectors), 2 * len(decays)), dtype=complex, order="F")
        twins[:, ::2] = vectors[:, decays]
        twins[:, 1::2] = vectors[:, decays].conj()
        return np.asfortranarray(np.hstack([vectors[:, alone], twins]))

    pairs = np.column_stack([kappa[decays], kappa[decays].conj()]).ravel()
    order = Approximation(values, ordered(modes.right), ordered(modes.left))
    return np.concatenate([kappa[alone], pairs]), order
