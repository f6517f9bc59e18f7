"""What every program offers that assembles the body."""

from typing import Any, Protocol

from scipy.sparse import csr_array

from cea.arrays import Floats
from comparisons.bench.annulus import Discretisation


class Assembler(Protocol):
    """A program with the body laid out in it: its space is made, its matrices are not."""

    def stiffness(self) -> Any:
        """Elastic stiffness of the free body, in the program's own form, made anew."""

    def mass(self) -> Any:
        """Its mass, in the program's own form, made anew; some give that of one component."""

    def compressed(self, matrix: Any) -> csr_array:
        """A matrix of its own in compressed rows."""

    def motions(self) -> Floats:
        """Coefficients of the six rigid motions (:mod:`comparisons.bench.rigid`), shape (n, 6)."""


class Program(Protocol):
    """Lays the body out."""

    def __call__(self, discretisation: Discretisation) -> Assembler:
        """The body so divided."""
