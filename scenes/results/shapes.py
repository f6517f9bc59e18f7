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
    body: str,
    trace: csr_array | None,
    vectors: Complexes,
    *,
    prescribed: float = 0.0,
) -> Complexes:
    """Displacements (m) of many vectors of unknowns at points of one body; collective.

    Parameters
    ----------
    system
        The coupled system.
    body
        Name of the body.
    trace
        Values of the scalar basis functions at the points of this rank, shape
        (n, num_scalar_dofs); None takes the scalar dofs themselves, this rank's share.
    vectors
        Unknowns, the rows of this rank, shape (n_local, k).
    prescribed
        Part of the displacements that supports prescribe which is added; none to small motions.

    Returns
    -------
    ndarray
        Shape (n, dim, k), the points of this rank.
    """
    part = system.bodies[body]
    start = system.template.getOwnershipRange()[0]
    own = vectors[system.index_sets[body].indices - start]
    if trace is None:
        u = _times(part.expansion, own, part.comm)
    else:
        operator = free_operator(csr_array(kron(trace, eye_array(part.dim), format="csr")), part)
        u = _times(operator, own, part.comm)
        destroy(operator)
    u = u.reshape(len(u) // part.dim, part.dim, vectors.shape[1])
    if not prescribed or part.prescribed is None:
        return u
    if trace is None:
        held = part.prescribed.array_r.reshape(-1, part.dim)
    else:
        held = trace @ gather(part.prescribed).reshape(-1, part.dim)
    return u + prescribed * held[..., None]


def _times(operator: Any, vectors: Complexes, comm: Any) -> Complexes:
    """The rows of this rank of a PETSc AIJ matrix times a block of vectors; collective.

    Ranks may have rows and no columns, which PETSc's product with a dense matrix does not bear.
    Only those entries of the vectors travel that some rank needs.
    """
    indptr, columns, data = operator.getValuesCSR()
    needed = np.unique(np.concatenate(comm.allgather(np.unique(columns))))
    first, last = operator.getOwnershipRangeColumn()
    mine = needed[(needed >= first) & (needed < last)] - first
    values = np.concatenate(comm.allgather(vectors[mine]))
    shape = (len(indptr) - 1, len(needed))
    return csr_array((data, np.searchsorted(needed, columns), indptr), shape=shape) @ values


def gathered_displacements(
    system: CoupledSystem,
    body: str,
    trace: csr_array | None,
    vectors: Complexes,
    *,
    prescribed: float = 0.0,
    everywhere: bool = True,
) -> Complexes:
    """:func:`displacements` at points that are the same on every rank, or are those of rank 0.

    Where not ``everywhere``, rank 0 alone gives the trace and gets the answer; others an empty one.
    """
    comm = system.bodies[body].comm
    if trace is not None:
        count = trace.shape[0]
        rows = local_rows(count, comm) if everywhere else (0, 0 if comm.rank else count)
        trace = trace[slice(*rows)]
    u = displacements(system, body, trace, vectors, prescribed=prescribed)
    if everywhere:
        return np.concatenate(comm.allgather(u))
    parts = comm.gather(u)
    return u[:0] if parts is None else np.concatenate(parts)


def displacements_at(
    system: CoupledSystem,
    place: str,
    at: SurfaceCoordinates | csr_array | None,
    vectors: Complexes,
    **options: Any,
) -> Complexes:
    """:func:`gathered_displacements` of a body, or of a surface "body.surface"."""
    body, _, name = place.partition(".")
    if body not in system.bodies:
        raise InputError("place", place, f"one of {', '.join(system.bodies)}")
    if name:
        surfaces = system.bodies[body].surfaces
        if name not in surfaces or not isinstance(at, SurfaceCoordinates):
            allowed = ", ".join(f"{body}.{each}" for each in surfaces)
            raise InputError("place", place, f"one of {allowed}, with coordinates on it")
        at = surfaces[name].trace(at)
    elif isinstance(at, SurfaceCoordinates):
        raise InputError("place", place, "a surface, body.surface, for coordinates on it")
    return gathered_displacements(system, body, at, vectors, **options)


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
        sums |= _whole("W", csr_array(low_rank.root()), comm)
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
