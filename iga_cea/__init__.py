"""NURBS backend: joined patches, refined, assembled and traced on surfaces.

Takes plain geometry (knots, control points, weights, named faces) and knows no other backend.
"""

from iga_cea.space import NurbsSpace

__all__ = ["NurbsSpace"]
