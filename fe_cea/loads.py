"""Forces of pressures, of forces on surfaces and on every part of a Lagrange body."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dolfinx.fem.petsc import assemble_vector

from cea.petsc import PETSc
from cea.supports.boundary import Force, Pressure, on_surfaces, through_body
from fe_cea.forms import body_force_form, pressure_form, traction_form
from fe_cea.surface import FESurface


@dataclass(frozen=True)
class Loads:
    """What loads a body.

    Parameters
    ----------
    pressures, forces
        The loads.
    facet_tags
        Tags of the boundary facets (dolfinx).
    surface_tags
        Tag of each named surface.
    """

    pressures: Sequence[Pressure]
    forces: Sequence[Force]
    facet_tags: Any
    surface_tags: Mapping[str, int]

    def vectors(self, V: Any, surfaces: Mapping[str, FESurface]) -> Iterator[Any]:
        """Forces on all dofs whose sum is the load, PETSc vectors.

        Parameters
        ----------
        V
            Vector Lagrange space (dolfinx).
        surfaces
            Surfaces of the body, whose areas share forces out.
        """
        for form in self._forms(V, surfaces):
            full = assemble_vector(form)
            full.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            yield full

    def _forms(self, V: Any, surfaces: Mapping[str, FESurface]) -> Iterator[Any]:
        if self.pressures:
            pressures = [(p, self.surface_tags[p.surface]) for p in self.pressures]
            yield pressure_form(V, pressures, self.facet_tags)
        for name, value in on_surfaces(self.forces):
            traction = value / surfaces[name].area
            yield traction_form(V, traction, self.surface_tags[name], self.facet_tags)
        if (through := through_body(self.forces)) is not None:
            yield body_force_form(V, through)
