"""dolfinx with both matrices as forms of vectors."""

from comparisons.bench.annulus import Discretisation
from comparisons.bench.assembly.programs.plain_dolfinx import PlainDolfinx


def lay_out(discretisation: Discretisation) -> PlainDolfinx:
    """The body with a mass of vectors."""
    return PlainDolfinx(discretisation, vector_mass=True)
