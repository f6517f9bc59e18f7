"""Bodies from mesh files, units of length of files, valid names of surfaces."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator

from cea.arrays import Floats
from cea.errors import require
from cea.mesh import Mesh
from meshes.placement import IN_PLACE, Placement

if TYPE_CHECKING:  # readers of files are brought in where there is a file
    from meshes.files.content import FileContent
    from meshes.files.part import Part


Unit = Literal["m", "cm", "mm", "um", "in", "ft"]
METRES: dict[Unit, tuple[float, float]] = {
    "m": (1, 1),
    "cm": (1, 100),
    "mm": (1, 1000),
    "um": (1, 10**6),
    "in": (254, 10**4),
    "ft": (3048, 10**4),
}
"""Each unit in metres, as a fraction: lengths are multiplied, then divided."""
_LONGEST = 100
"""Largest number of characters of a name of a surface."""


def in_metres(values: Floats, unit: Unit | None) -> Floats:
    """Lengths of a file in metres; as they are without a unit."""
    if unit is None:
        return values
    above, below = METRES[unit]
    return values * above / below


def check_unit(unit: str | None, place: str, *, si: bool) -> None:
    """Refuse a file without a unit of length in a scene in SI units, and with one in others."""
    allowed = f"the unit of length of the file, one of {', '.join(get_args(Unit))}"
    if not si:
        allowed = "left out where units = 'other': lengths of the file are taken as they are"
    require((unit is not None) == si, f"{place}.unit", unit, allowed)


def is_fit(name: str) -> bool:
    """Whether a name can stand in "body.surface"."""
    return 0 < len(name) <= _LONGEST and name.isprintable() and not set(name) & set(" .,[]")


def _one_or_more(sets: Any) -> Any:
    """Tuple of one name or of several."""
    if isinstance(sets, str):
        return (sets,)
    return tuple(sets) if isinstance(sets, list) else sets


Sets = Annotated[
    tuple[str, ...],
    BeforeValidator(_one_or_more, json_schema_input_type=str | tuple[str, ...]),
]
"""Sets of a file that make a surface; one alone may be given by its name."""


@dataclass(frozen=True)
class MeshFile:
    """A body from a mesh file: cells, their order and curved sides are those of the file.

    Formats are .msh of gmsh, .inp of Abaqus and CalculiX, .cdb of Ansys (CDWRITE), .bdf and .nas of
    Nastran, .xdmf and .vtu.

    Parameters
    ----------
    file
        The file; in a scene file, relative to it.
    unit
        Unit of length of the file: m, cm, mm, um, in or ft, needed in a scene in SI units. Left out
        in a scene with ``units = "other"``: lengths of the file are then taken as they are.
    part
        Set of the elements of the body: a physical group, an element set, a component, the instance
        of a part, or ``PSOLID 3``, ``material 1`` and the like; all solid elements by default.
    faces
        Named surfaces: a set of the file or several, physical groups, surfaces, sets of elements or
        of nodes; ``SET:S3`` for the third faces of the elements of a set, as Abaqus counts them;
        ``nodes:SET`` where sets of several kinds have a name. Sets of the file whose names are fit
        for surfaces need not be listed here.
    merge_nodes
        Distance, in the unit of the file, within which nodes are merged; by default none are.

    Raises
    ------
    InputError
        When the file cannot be read, or the part has no elements that can form a body.
    """

    file: str
    unit: Unit | None = None
    part: str | None = None
    faces: dict[str, Sets] = field(default_factory=dict)
    merge_nodes: float | None = None
    shape: Literal["mesh_file"] = "mesh_file"

    def __post_init__(self) -> None:
        fits = self.merge_nodes is None or 0 < self.merge_nodes < np.inf
        allowed = "a positive distance in the unit of the file"
        require(fits, "merge_nodes", self.merge_nodes, allowed)
        faces = {name: _one_or_more(sets) for name, sets in self.faces.items()}
        object.__setattr__(self, "faces", faces)
        empty = [name for name, sets in faces.items() if not sets]
        require(not empty, "faces", empty, "one set of the file or more for each surface")
        require(bool(self.extent), "part", self.part, "elements")

    @property
    def content(self) -> "FileContent":
        """Content of the file."""
        from meshes.files.reading import read_mesh_file

        return read_mesh_file(Path(self.file), self.merge_nodes)

    @cached_property
    def elements(self) -> "Part":
        """Elements of the body in the file."""
        from meshes.files.part import part_of
        from meshes.files.surfaces import marking_sets

        marks = marking_sets(self.content, self.faces)
        return part_of(self.content, Path(self.file).name, self.part, marks)

    def _faces(self, surfaces: Iterable[str]) -> "dict[str, tuple[NDArray[np.bool_], int]]":
        """Faces of elements on each surface, and the number of nodes of its sets on none."""
        from meshes.files.surfaces import surface_faces

        sets = {name: self.faces.get(name, (name,)) for name in surfaces}
        return surface_faces(self.content, self.elements, sets)

    @cached_property
    def directions(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return ("x", "y", "z")[: self.elements.dim]

    @cached_property
    def surfaces(self) -> tuple[str, ...]:
        """Names of surfaces that the body may have."""
        of_file = [name for name in self.content.names if is_fit(name)]
        return tuple(dict.fromkeys([*self.faces, *of_file]))

    @cached_property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of each coordinate (m)."""
        used = self.content.points[self.elements.used, : self.elements.dim]
        low, high = (in_metres(ends, self.unit) for ends in (used.min(axis=0), used.max(axis=0)))
        return tuple(zip(low.tolist(), high.tolist(), strict=True))

    def nodes_left_out(self, surfaces: Iterable[str]) -> dict[str, int]:
        """Number of nodes in the sets of each surface that lie on none of its faces."""
        return {name: count for name, (_, count) in self._faces(surfaces).items() if count}

    def mesh(self, surfaces: Iterable[str], placement: Placement = IN_PLACE) -> Mesh:
        """Checked mesh with given surfaces only: others may overlap these."""
        from meshes.files.part import body_mesh

        faces = {name: on for name, (on, _) in self._faces(surfaces).items()}
        mesh = body_mesh(self.content, self.elements, faces, self.part)
        return replace(mesh, points=placement.apply(in_metres(mesh.points, self.unit)))
