"""NURBS backend: refinement of joined patches, assembly, and traces on surfaces.

Its input is plain geometry (knots, control points, weights, named faces).
"""

from iga_cea.space import NurbsSpace

__all__ = ["NurbsSpace"]
