"""Lumped contact: the blocks of each side summed onto their diagonal.

Mohanasundaram et al. (2023), eq. 41. In the block a-a scalar row i takes its sum over the scalar
columns j, which leaves a dim x dim block sum_q w p N_i(x_q) n n^T, and sum_q mu w p N_i k n^T in
K_f; likewise b-b. The blocks a-b between the sides stay consistent. This is not of the form
G^T D G: translations of both bodies together are free, common rotations no longer are.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.sparse import bsr_array, csr_array

from cea.arrays import Floats
from cea.body import Body
from cea.body.unknowns import system_operator
from cea.contact.interface import Interface, along
from cea.matrices import (
    block_diagonal,
    destroy,
    distributed,
    product,
    symmetrised,
    total,
)
from cea.petsc import MPI, PETSc


def lumped_matrices(
    bodies: Mapping[str, Body],
    sides: tuple[str, str],
    interface: Interface,
    weight: Floats,
    pushed: Floats | None,
) -> tuple[Any, Any | None]:
    """K_n and K_f of lumped contact in the unknowns of the system; pushed along mu k."""
    normal = interface.local_points.normal
    stiffness = _lumped(bodies, sides, interface, weight, normal, normal)
    symmetrised(stiffness)
    stiffness.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    if pushed is None:
        return stiffness, None
    return stiffness, _lumped(bodies, sides, interface, weight, pushed, normal)


def _lumped(
    bodies: Mapping[str, Body],
    sides: tuple[str, str],
    interface: Interface,
    weight: Floats,
    left: Floats,
    right: Floats,
) -> Any:
    """Jump along ``left`` against jump along ``right``, each side's own block lumped."""
    traces = dict(zip(sides, (interface.trace_a, interface.trace_b), strict=True))
    rows = len(weight)
    factor = PETSc.Vec().createMPI((rows, PETSc.DETERMINE), comm=interface.comm)
    factor.array[:] = -weight
    parts = [_own_blocks(bodies, traces, weight, left, right, interface.comm)]
    for one, other in (sides, sides[::-1]):
        test = system_operator(bodies, {one: along(traces[one], left)}, rows)
        trial = system_operator(bodies, {other: along(traces[other], right)}, rows)
        parts.append(product(test, trial, factor))
        destroy(test, trial)
    result = total(parts)
    destroy(factor, *parts)
    return result


def _own_blocks(
    bodies: Mapping[str, Body],
    traces: Mapping[str, csr_array],
    weight: Floats,
    left: Floats,
    right: Floats,
    comm: Any,
) -> Any:
    """Lumped blocks of both sides, block diagonal."""
    blocks = []
    for name, body in bodies.items():
        full = (body.dim * body.num_scalar_dofs,) * 2
        lumped = csr_array(full)
        if name in traces:
            lumped = comm.allreduce(_lumped_block(traces[name], weight, left, right), MPI.SUM)
        own = csr_array(lumped[slice(*body.expansion.getOwnershipRange())])
        matrix = distributed(own, body.expansion.getSizes()[0], body.comm)
        blocks.append(matrix.ptap(body.expansion))
        destroy(matrix)
    result = block_diagonal(blocks).convert("aij")
    destroy(*blocks)
    return result


def _lumped_block(trace: csr_array, weight: Floats, left: Floats, right: Floats) -> csr_array:
    """Sum over points of w N_i l r^T on the diagonal block of scalar dof i."""
    dim = left.shape[1]
    outer = np.einsum("q,qc,qd->qcd", weight, left, right).reshape(len(weight), -1)
    blocks = np.asarray(trace.T @ outer).reshape(-1, dim, dim)
    n = len(blocks)
    lumped = csr_array(bsr_array((blocks, np.arange(n), np.arange(n + 1))))
    lumped.eliminate_zeros()
    return lumped
