"""NURBS backend: elastic bodies of joined patches, refined, assembled and traced on surfaces.

Takes plain geometry (knots, control points, weights, named faces) and knows no other backend.
Importing `cea` before anything else here brings the PETSc stack into a safe order.
"""

import cea  # noqa: F401
from iga_cea.body import NurbsBody

__all__ = ["NurbsBody"]
