"""Backend: Lagrange finite elements on meshes of triangles, quadrilaterals, tetrahedra, hexahedra.

Importing `cea` before anything else here brings the PETSc stack into a safe order.
"""

import cea  # noqa: F401
from fe_cea.body import FEBody
from fe_cea.surface import FESurface

__all__ = ["FEBody", "FESurface"]
