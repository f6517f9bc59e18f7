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
from cea.body.body import system_operator
from cea.contact.interface import Interface, along
from cea.matrices import block_diagonal, destroy, distributed, product, scaled_total, symmetrised
from cea.petsc import MPI, PETSc


def lumped_matrices(
    bodies: Mapping[str, Body],
    sides: tuple[str, str],
    interface: Interface,
    weight: Floats,
    pushed: Floats | None,
) -> tuple[Any, Any | None]:
    """K_n and K_f of lumped contact in the unknowns of the system; pushed along mu k."""
    traces = dict(zip(sides, (interface.trace_a, interface.trace_b), strict=True))
    normal = interface.local_points.normal
    stiffness = symmetrised(_lumped(bodies, traces, weight, normal, normal))
    stiffness.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    if pushed is None:
        return stiffness, None
    return stiffness, _lumped(bodies, traces, weight, pushed, normal)


def _lumped(
    bodies: Mapping[str, Body],
    traces: Mapping[str, csr_array],
    weight: Floats,
    left: Floats,
    right: Floats,
) -> Any:
    """Jump along ``left`` against jump along ``right``, each side's own block lumped."""
    rows, blocks = len(weight), []
    for name, body in bodies.items():
        whole = csr_array((body.dim * body.num_scalar_dofs,) * 2)
        if name in traces:
            whole = body.comm.allreduce(_block(traces[name], weight, left, right), MPI.SUM)
        own = csr_array(whole[slice(*body.expansion.getOwnershipRange())])
        matrix = distributed(own, body.expansion.getSizes()[0], body.comm)
        blocks.append(body.reduced(matrix, exactly=lambda reduced: reduced))
    parts = [block_diagonal(blocks).convert("aij")]
    destroy(*blocks)
    one, other = traces
    for test_side, trial_side in ((one, other), (other, one)):
        test = system_operator(bodies, {test_side: along(traces[test_side], left)}, rows)
        trial = system_operator(bodies, {trial_side: along(traces[trial_side], right)}, rows)
        parts.append(product(test, trial, -weight))
        destroy(test, trial)
    result = scaled_total([(1.0, part) for part in parts])
    destroy(*parts)
    return result


def _block(trace: csr_array, weight: Floats, left: Floats, right: Floats) -> csr_array:
    """Sum over points of w N_i l r^T on the diagonal block of scalar dof i."""
    dim = left.shape[1]
    outer = np.einsum("q,qc,qd->qcd", weight, left, right).reshape(len(weight), -1)
    blocks = np.asarray(trace.T @ outer).reshape(-1, dim, dim)
    n = len(blocks)
    lumped = csr_array(bsr_array((blocks, np.arange(n), np.arange(n + 1))))
    lumped.eliminate_zeros()
    return lumped
