"""What tells the pencil of a map from others, though the words that ask for it are the same.

A scene, a mesh or a matrix may change under its name while a sweep is interrupted. Norms alone do
not see that unknowns are numbered otherwise or that friction pulls the other way: each matrix is
multiplied from both sides by vectors that are the same each time. Warnings depend on the scene too.
"""

from collections.abc import Iterator, Mapping
from hashlib import sha256
from typing import Any

import numpy as np

from cea import __version__
from cea.arrays import Floats
from cea.eigen.parameters import Dependence
from cea.eigen.pencil import Pencil
from cea.eigen.unformed import LowRank
from comparisons.sweep.mapped import Mapped
from scenes.results.record import as_json

_PARTS = (0.0, 0.381966, 1.0)
"""Where between the ends of all axes coefficients are looked at."""


def fingerprint(scene: Mapped) -> list[str]:
    """What a map rests on, number by number, the same on every rank.

    Parameters
    ----------
    scene
        What is mapped.
    """
    pencil = scene.pencil
    window = (scene.max_frequency, scene.min_growth, scene.growth_threshold)
    return [
        f"program {__version__}",
        *(f"{each.name} {each.value!r}" for each in pencil.parameters.values()),
        *_pieces(pencil, list(_probed(scene))),
        f"window {window!r}",
        f"scene {sha256(as_json(scene.scene).encode()).hexdigest()}",
    ]


def _probed(scene: Mapped) -> Iterator[Mapping[str, float]]:
    """Values of all parameters at some places of the map."""
    for shift in range(len(_PARTS)):
        parts = [_PARTS[(shift + i) % len(_PARTS)] for i in range(len(scene.axes))]
        ends = [axis.ends for axis in scene.axes]
        at = [low + part * (high - low) for part, (low, high) in zip(parts, ends, strict=True)]
        yield scene.pencil.values(scene.point(at))


def _pieces(pencil: Pencil, probed: list[Mapping[str, float]]) -> Iterator[str]:
    def of(*coefficients: Dependence) -> str:
        return " ".join(f"{each.at(values):.10e}" for each in coefficients for values in probed)

    for term in pencil.terms:
        about = f"{term.role} {'symmetric' if term.symmetric else 'unsymmetric'}"
        yield f"{about} {_of_matrix(term.matrix)} {of(term.coefficient)}"
    for forces in pencil.forces:
        parts = (forces.closure, forces.slip, forces.compliance)
        told = " ".join(_of_matrix(each) for each in parts if each is not None)
        yield f"forces {told} {of(forces.inverse_stiffness, forces.friction)}"
    for circulatory in pencil.circulatory:
        piece = circulatory.piece
        told = " ".join(_of_matrix(each) for each in (piece.left, piece.middle, piece.right))
        yield f"circulatory {told} {of(circulatory.coefficient)}"
    comm = pencil.comm.tompi4py()
    for low_rank in pencil.low_rank:
        yield f"low rank {_of_low_rank(low_rank.piece, comm)} {of(low_rank.coefficient)}"


def _of_matrix(matrix: Any) -> str:
    """Size, norm, and u^T A v in that norm."""
    v, u = matrix.createVecs()
    for vector in (u, v):
        vector.array = _tested(vector.getLocalSize(), vector.getOwnershipRange()[0])
    image = u.duplicate()
    matrix.mult(v, image)
    product, norm = image.dot(u), matrix.norm()
    for vector in (u, v, image):
        vector.destroy()
    relative = product / norm if norm else 0.0
    return f"{matrix.getSize()} {norm:.10e} {relative:.6f}"


def _of_low_rank(piece: LowRank, comm: Any) -> str:
    """Weights, and a vector times the vectors."""
    tested = _tested(len(piece.vectors), piece.first) @ piece.vectors
    tested = comm.bcast(comm.allreduce(tested))
    return " ".join(f"{each:.6e}" for each in (*piece.weights.tolist(), *tested.tolist()))


def _tested(rows: int, first: int) -> Floats:
    """Rows of a vector that is the same each time, each number of its own."""
    return np.random.default_rng(first).standard_normal(rows)
