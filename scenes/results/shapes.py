"""Displacements and matrices of results as numpy and scipy arrays."""

from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array, kron, vstack

from cea.arrays import Complexes
from cea.body import free_operator
from cea.eigen.block_products import times
from cea.eigen.multipliers import with_unformed
from cea.eigen.pencil import Pencil, Term
from cea.errors import InputError, require
from cea.matrices import destroy, local_part, scaled_total
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
    """Return displacements (m), (n, dim, k), at points for k vectors of unknowns; collective.

    ``place`` and ``at`` are as in :meth:`scenes.results.result.Result.mode_shapes`; ``vectors`` are
    the rows of this rank; ``prescribed`` is the factor of the prescribed displacements to add.
    """
    name, trace = _trace(system, place, at)
    body, comm = system.bodies[name], system.bodies[name].comm
    own = vectors[system.pieces[name].rows]
    held = body.prescribed if prescribed else None
    if trace is None:
        u = times(body.expansion, own)
        fixed = held
    else:
        count = trace.shape[0]
        first, last = local_rows(count, comm) if everywhere else (0, 0 if comm.rank else count)
        every = csr_array(kron(trace[first:last], eye_array(body.dim), format="csr"))
        operator = free_operator(every, body)
        u = times(operator, own)
        destroy(operator)
        fixed = None if held is None else every @ np.concatenate(comm.allgather(held))
    if fixed is not None:
        u += prescribed * fixed[:, None]
    u = u.reshape(len(u) // body.dim, body.dim, vectors.shape[1])
    parts = comm.allgather(u) if everywhere else comm.gather(u)
    return u[:0] if parts is None else np.concatenate(parts)


def _trace(
    system: CoupledSystem, place: str, at: SurfaceCoordinates | csr_array | None
) -> tuple[str, csr_array | None]:
    """Return the body of a place, and the values of its basis functions at the points."""
    body, _, name = place.partition(".")
    require(body in system.bodies, "place", place, f"one of {', '.join(system.bodies)}")
    if not name and not isinstance(at, SurfaceCoordinates):
        return body, at
    surfaces = system.bodies[body].surfaces
    if name not in surfaces or not isinstance(at, SurfaceCoordinates):
        allowed = ", ".join(f"{body}.{each}" for each in surfaces)
        raise InputError("place", place, f"one of {allowed}, with coordinates on it")
    return body, surfaces[name].trace(at)


def system_matrices(system: CoupledSystem, values: Mapping[str, float]) -> dict[str, csr_array]:
    """Return the matrices of :meth:`scenes.results.result.Result.matrices`; collective."""
    for contact in system.contacts:
        name = f"contacts.{contact.pair}.P"
        stiffness = values.get(name, 0.0)
        require(stiffness < inf, name, stiffness, "finite for matrices")
    pencil, comm = system.pencil(eliminate=True), system.template.comm.tompi4py()
    has_mass = any(term.role == "mass" for term in pencil.terms)
    names = ("K", "M", "K_n", "K_f") if has_mass else ("K", "K_n", "K_f")
    sums = _sums(pencil.terms, values, system.template, _name, names)
    low_rank, circulatory = pencil.low_rank_at(values), pencil.circulatory_unknowns(values)
    if low_rank is not None:
        sums |= _whole("W", csr_array(low_rank.vectors), comm)
    if (full := with_unformed(None, circulatory)) is not None:
        left = full.reaction.transpose(PETSc.Mat())
        for name, matrix in (("L", left), ("N", full.compliance), ("J", full.closure)):
            sums |= _whole(name, local_part(matrix), comm)
        full.free()
        destroy(left)
    return sums


def given_matrices(pencil: Pencil, values: Mapping[str, float], template: Any) -> dict[str, Any]:
    """Return M, C if there is damping, and K of a pencil of matrices from files; collective."""
    letters = {"mass": "M", "damping": "C", "stiffness": "K"}
    return _sums(pencil.terms, values, template, lambda term: letters[term.role])


def _name(term: Term) -> str:
    """Return the name of the matrix that a term of bodies or contacts belongs to."""
    if term.role == "stiffness":
        both = ("K_n", "K_f") if term.contact else ("K", "K_c")
        return both[0 if term.symmetric else 1]
    return "M" if term.role == "mass" else "C" if term.symmetric else "Y"


def _sums(
    terms: Iterable[Term],
    values: Mapping[str, float],
    template: Any,
    name_of: Callable[[Term], str],
    names: Iterable[str] = (),
) -> dict[str, csr_array]:
    """Sum terms by name on rank 0, with zero matrices for ``names`` without terms; collective.

    K_f enters the pencil with a minus sign.
    """
    pieces: dict[str, list[tuple[float, Any]]] = {name: [] for name in names}
    for term in terms:
        name, factor = name_of(term), term.coefficient.at(values)
        own = pieces.setdefault(name, [])
        if factor:
            own.append((-factor if name == "K_f" else factor, term.matrix))
    sums: dict[str, csr_array] = {}
    for name, parts in pieces.items():
        rows = csr_array((template.getLocalSize(), template.getSize()))
        if parts:
            matrix = scaled_total(parts)
            rows = local_part(matrix)
            destroy(matrix)
        sums |= _whole(name, rows, template.comm.tompi4py())
    return sums


def _whole(name: str, rows: csr_array, comm: Any) -> dict[str, csr_array]:
    """Gather the rows of a matrix on rank 0 as ``{name: matrix}``, ``{}`` elsewhere; collective."""
    parts = comm.gather(rows)
    return {name: csr_array(vstack(parts, format="csr"))} if parts is not None else {}
