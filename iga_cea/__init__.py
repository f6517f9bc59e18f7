"""NURBS backend: elastic bodies of joined patches, refined, assembled and traced on surfaces.

Takes plain geometry (knots, control points, weights, named faces) and knows no other backend.
"""

from iga_cea.body import NurbsBody

__all__ = ["NurbsBody"]
