"""Backend: Lagrange finite elements on meshes of triangles, quadrilaterals, tetrahedra, hexahedra.

PETSc is imported before dolfinx.
"""

import cea.petsc  # noqa: F401
from fe_cea.space import LagrangeSpace
from fe_cea.surface import FESurface

__all__ = ["FESurface", "LagrangeSpace"]
