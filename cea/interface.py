"""A contact interface: a point rule on surface a, located on surface b, and its operators.

With n the outward unit normal of a and k the direction of the friction traction on a,

    G = [n.N_a, -n.N_b]     gap operator (points x full dofs), penetration positive
    T = [k.N_a, -k.N_b]     slip operator
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_array

from cea.body import Body, Floats, Location, Status, Surface, SurfacePoints
from cea.errors import InputError

_FACING = -0.5
"""Largest cosine between the normals of two surfaces that face each other."""


@dataclass(frozen=True)
class Interface:
    """Points of a rule on side a paired with side b.

    Parameters
    ----------
    a, b
        The two surfaces.
    points
        Points of the rule on a.
    opposite
        Where each point was found on b along the normal of a.
    trace_a, trace_b
        Values of the scalar basis functions of both sides at the points, evaluated once.
    """

    a: Surface
    b: Surface
    points: SurfacePoints
    opposite: Location
    trace_a: csr_array
    trace_b: csr_array

    def jump(self, direction: Floats) -> tuple[csr_array, csr_array]:
        """Parts on a and b of the jump along a direction, (n, dim * num_scalar_dofs) each.

        Parameters
        ----------
        direction
            Unit vectors at the points, shape (n, dim): normals for G, friction direction for T.
        """
        return along(self.trace_a, direction), -along(self.trace_b, direction)


def pair(
    a: Surface,
    b: Surface,
    points: SurfacePoints,
    *,
    field: str = "contact",
    reach: float | None = None,
    max_missed: float = 0.0,
) -> Interface:
    """Locate the points of a rule on side a on the surface of side b.

    Parameters
    ----------
    a, b
        The two surfaces.
    points
        Points of the rule on a.
    field
        Name of the contact, for messages.
    reach
        Largest distance (m) between the surfaces along the normal; by default half the larger
        mesh size.
    max_missed
        Largest fraction of the rule's area that may find nothing on b; such points are dropped.

    Raises
    ------
    InputError
        When too many points are missed, or the surfaces do not face each other.
    """
    if reach is None:
        reach = 0.5 * max(a.mesh_size, b.mesh_size)
    opposite = b.locate(points.x, points.normal, reach)
    missed = opposite.missed
    fraction = float(points.weight[missed].sum() / points.weight.sum())
    if fraction > max_missed:
        raise InputError(
            field,
            f"{a.name} on {b.name}",
            f"surfaces that face each other within {reach:.3g} m: {missed.sum()} of {len(points)} "
            f"points ({fraction:.1%} of the area of side a) find nothing on side b, "
            f"at most {max_missed:.1%} may",
        )
    found = ~missed
    points, opposite = points[found], _select(opposite, found)
    cosine = np.einsum("ij,ij->i", points.normal, b.normal(opposite.at))
    if len(cosine) == 0 or cosine.max() > _FACING:
        worst = float(cosine.max()) if len(cosine) else float("nan")
        raise InputError(
            field,
            f"{a.name} on {b.name}",
            f"surfaces that face each other (their outward normals have cosine {worst:.3g}, "
            f"{_FACING} or less is allowed)",
        )
    return Interface(a, b, points, opposite, a.trace(points.at), b.trace(opposite.at))


def along(trace: csr_array, direction: Floats) -> csr_array:
    """Component of the displacement along a direction, as an operator on full dofs.

    Parameters
    ----------
    trace
        Scalar trace, shape (n, num_scalar_dofs).
    direction
        Unit vectors, shape (n, dim).

    Returns
    -------
    csr_array
        Shape (n, dim * num_scalar_dofs); component c of scalar dof i is column ``dim * i + c``.
    """
    n, m = trace.shape
    dim = direction.shape[1]
    row = np.repeat(np.arange(n), np.diff(trace.indptr))
    data = trace.data[:, None] * direction[row]
    columns = trace.indices.astype(np.int64)[:, None] * dim + np.arange(dim)
    return csr_array(
        (data.ravel(), columns.ravel(), trace.indptr.astype(np.int64) * dim), shape=(n, m * dim)
    )


def free_operator(operator: csr_array, body: Body) -> Any:
    """Distribute an operator on full dofs by rows and restrict it to free dofs.

    Parameters
    ----------
    operator
        The whole operator, the same on every rank, shape (n, dim * num_scalar_dofs).
    body
        The body whose dofs are its columns.

    Returns
    -------
    PETSc.Mat
        AIJ matrix (n x free dofs).
    """
    comm = body.comm
    start, stop = local_rows(operator.shape[0], comm)
    rows = operator[start:stop]
    local_columns = body.expansion.getSizes()[0][0]
    full = PETSc.Mat().createAIJ(
        size=((stop - start, operator.shape[0]), (local_columns, operator.shape[1])),
        csr=(
            rows.indptr.astype(PETSc.IntType),
            rows.indices.astype(PETSc.IntType),
            rows.data,
        ),
        comm=comm,
    )
    return full.matMult(body.expansion)


def local_rows(n: int, comm: Any) -> tuple[int, int]:
    """First row of this rank and of the next, when n rows are shared out evenly."""
    return comm.rank * n // comm.size, (comm.rank + 1) * n // comm.size


def _select(location: Location, rows: np.ndarray) -> Location:
    return Location(
        location.at[rows],
        location.distance[rows],
        location.miss[rows],
        location.status[rows],
        location.tolerance,
    )


def count_statuses(location: Location) -> dict[str, int]:
    """Number of points of each status, by name in lower case."""
    return {s.name.lower(): int((location.status == s).sum()) for s in Status}
