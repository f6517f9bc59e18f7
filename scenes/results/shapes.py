"""Arrays of numpy and scipy from distributed vectors and matrices."""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array, kron, vstack

from cea.arrays import Complexes
from cea.body.unknowns import free_operator
from cea.eigen.multipliers import with_circulatory
from cea.errors import InputError
from cea.matrices import destroy, gather, local_part, scaled_total
from cea.petsc import PETSc
from cea.ranks import local_rows
from cea.surface_points import SurfaceCoordinates
from cea.system.coupled import CoupledSystem


def displacements(
    system: CoupledSystem,
    place: str,
    at: SurfaceCoordinates | csr_array | None,
    vectors: Complexes,
    *,
    prescribed: float = 0.0,
    everywhere: bool = True,
) -> Complexes:
    """Displacements (m) of many vectors of unknowns at points; collective.

    Parameters
    ----------
    system
        The coupled system.
    place
        A body; or a surface, "body.surface".
    at
        On a surface, coordinates of the points, as locating gives them. On a body, the values of
        its scalar basis functions at the points, shape (n, num_scalar_dofs); None takes the scalar
        dofs themselves.
    vectors
        Unknowns, the rows of this rank, shape (n_local, k).
    prescribed
        Part of the displacements that supports prescribe which is added; none to small motions.
    everywhere
        Whether every rank gives the points and gets the answer; otherwise rank 0 does, and others
        get an empty array.

    Returns
    -------
    ndarray
        Shape (n, dim, k).
    """
    name, trace = _trace(system, place, at)
    body, comm = system.bodies[name], system.bodies[name].comm
    start = system.template.getOwnershipRange()[0]
    own = vectors[system.index_sets[name].indices - start]
    held = body.prescribed if prescribed else None
    if trace is None:
        u = times(body.expansion, own)
        fixed = None if held is None else held.array_r
    else:
        count = trace.shape[0]
        first, last = local_rows(count, comm) if everywhere else (0, 0 if comm.rank else count)
        every = csr_array(kron(trace[first:last], eye_array(body.dim), format="csr"))
        operator = free_operator(every, body)
        u = times(operator, own)
        destroy(operator)
        fixed = None if held is None else every @ gather(held)
    if fixed is not None:
        u += prescribed * fixed[:, None]
    u = u.reshape(len(u) // body.dim, body.dim, vectors.shape[1])
    parts = comm.allgather(u) if everywhere else comm.gather(u)
    return u[:0] if parts is None else np.concatenate(parts)


def _trace(
    system: CoupledSystem, place: str, at: SurfaceCoordinates | csr_array | None
) -> tuple[str, csr_array | None]:
    """Body of a place, and values of its basis functions at points there."""
    body, _, name = place.partition(".")
    if body not in system.bodies:
        raise InputError("place", place, f"one of {', '.join(system.bodies)}")
    if not name and not isinstance(at, SurfaceCoordinates):
        return body, at
    surfaces = system.bodies[body].surfaces
    if name not in surfaces or not isinstance(at, SurfaceCoordinates):
        allowed = ", ".join(f"{body}.{each}" for each in surfaces)
        raise InputError("place", place, f"one of {allowed}, with coordinates on it")
    return body, surfaces[name].trace(at)


def times(operator: Any, vectors: Complexes) -> Complexes:
    """The rows of this rank of a PETSc matrix times vectors, (n_local, k); collective."""
    x, y = operator.createVecs()
    products = np.empty((y.getLocalSize(), vectors.shape[1]), dtype=complex)
    for j, vector in enumerate(vectors.T):
        for target, part in ((products.real, vector.real), (products.imag, vector.imag)):
            x.array[:] = part
            operator.mult(x, y)
            target[:, j] = y.array_r
    destroy(x, y)
    return products


def system_matrices(system: CoupledSystem, values: Mapping[str, float]) -> dict[str, csr_array]:
    """Matrices of bodies and contacts, as :meth:`scenes.results.result.Result.matrices` says."""
    for contact in system.contacts:
        name = f"contacts.{contact.pair}.P"
        if not values.get(name, 0.0) < inf:
            raise InputError(name, values[name], "finite for matrices")
    pencil = system.pencil(eliminate=True)
    pieces: dict[str, list[tuple[float, Any]]] = {"K": [], "M": [], "K_n": [], "K_f": []}
    for term in pencil.terms:
        factor = term.coefficient.at(values)
        if term.role == "stiffness":
            names = ("K_n", "K_f") if term.contact else ("K", "K_c")
            name = names[0 if term.symmetric else 1]
        else:
            name = "M" if term.role == "mass" else "C" if term.symmetric else "Y"
        sign = -1 if name == "K_f" else 1
        pieces.setdefault(name, []).append((sign * factor, term.matrix))
    if not pieces["M"]:
        del pieces["M"]
    sums = _sums(pieces, system.template)
    comm = system.template.comm.tompi4py()
    low_rank, circulatory = pencil.low_rank_at(values), pencil.circulatory_at(values)
    if low_rank is not None:
        sums |= _whole("W", csr_array(low_rank.vectors), comm)
    if circulatory is not None:
        full = with_circulatory(None, circulatory)
        left = full.reaction.transpose(PETSc.Mat())
        for name, matrix in (("L", left), ("N", full.compliance), ("J", full.closure)):
            sums |= _whole(name, local_part(matrix), comm)
        full.free()
        destroy(left)
    return sums


def summed_matrices(
    pencil: Any, values: Mapping[str, float], template: Any
) -> dict[str, csr_array]:
    """M, C where there is one, and K of a pencil of matrices from files; collective."""
    letters = {"mass": "M", "damping": "C", "stiffness": "K"}
    pieces: dict[str, list[tuple[float, Any]]] = {}
    for term in pencil.terms:
        pieces.setdefault(letters[term.role], []).append((term.coefficient.at(values), term.matrix))
    return _sums(pieces, template)


def _sums(pieces: Mapping[str, Sequence[tuple[float, Any]]], template: Any) -> dict[str, csr_array]:
    """Sums of factors times PETSc AIJ matrices by name, on rank 0 alone; collective."""
    n, comm = template.getSize(), template.comm.tompi4py()
    sums: dict[str, csr_array] = {}
    for name, parts in pieces.items():
        kept = [(factor, matrix) for factor, matrix in parts if factor]
        rows = csr_array((template.getLocalSize(), n))
        if kept:
            matrix = scaled_total(kept)
            indptr, indices, data = matrix.getValuesCSR()
            rows = csr_array((data, indices, indptr), shape=rows.shape)
            destroy(matrix)
        sums |= _whole(name, rows, comm)
    return sums


def _whole(name: str, rows: csr_array, comm: Any) -> dict[str, csr_array]:
    """A matrix of which each rank has its rows, whole under a name, on rank 0 alone; collective."""
    parts = comm.gather(rows)
    return {name: csr_array(vstack(parts, format="csr"))} if parts is not None else {}
