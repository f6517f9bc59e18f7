"""A body whose NURBS patches come from a file of splinepy or G+Smo."""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from cea.errors import InputError, require
from meshes.files.splines import FileSplines, Spline, json_splines, xml_splines
from meshes.files.state import checked_state
from meshes.mesh_file import Unit, check_unit, in_metres, is_fit
from meshes.patches import Face, GivenPatch, Patches

_KEPT = 4
"""Files whose content is kept, for the bodies of a scene."""
_LARGEST = 2**28
"""Bytes of a file."""


@dataclass(frozen=True)
class NurbsFile:
    """A body of the NURBS patches of a file, joined where their faces coincide.

    Formats are the .json of splinepy and the .xml of G+Smo (gismo). Degrees are raised and knots
    inserted as the mesh says, as those of :class:`meshes.patches.Patches`; what the file has stays.

    Parameters
    ----------
    file
        The file; in a scene file, relative to it.
    unit
        Unit of length of the file: m, cm, mm, um, in or ft. There is no default.
    faces
        Faces [patch, axis, side] of each named surface; side 0 is where the parameter is least.
        Boundaries that a file of G+Smo names need not be listed here.
    merge_nodes
        Distance, in the unit of the file, within which control points are made one; by default none
        are.

    Raises
    ------
    InputError
        When the file cannot be read, or holds no patches that make a body.
    """

    file: str
    unit: Unit | None = None
    faces: dict[str, tuple[Face, ...]] = field(default_factory=dict)
    merge_nodes: float | None = None
    shape: Literal["nurbs_file"] = "nurbs_file"

    left_out: ClassVar[tuple[str, ...]] = ("merge_nodes",)
    """Fields left out of plain data where they say nothing (:mod:`scenes.plain`)."""

    def __post_init__(self) -> None:
        check_unit(self.unit)
        require(bool(self.given.patches), "file", self.file, "patches")

    @cached_property
    def given(self) -> Patches:
        """Its patches (m)."""
        assert self.unit is not None
        content = _read(*checked_state(Path(self.file), "a file of patches", _LARGEST))
        faces = {name: ends for name, ends in content.faces.items() if is_fit(name)} | self.faces
        try:
            patches = tuple(_patch(spline, self.unit) for spline in content.splines)
        except InputError as error:
            raise InputError("file", f"{self.file}: {error.field}", error.allowed) from None
        near = self.merge_nodes
        if near is not None:
            near = float(in_metres(np.array(near), self.unit))
        return Patches(patches, faces, near)

    @property
    def directions(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return self.given.directions

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return self.given.surfaces

    @property
    def extent(self) -> tuple[tuple[float, float], ...]:
        """Range of the scaled parameters."""
        return self.given.extent


def _patch(spline: Spline, unit: Unit) -> GivenPatch:
    """A patch in metres; of points in space, a patch of the plane keeps x and y."""
    dim, points = len(spline.degrees), spline.points
    if dim == 2 and points.shape[-1] == 3:
        flat = bool((points[..., 2] == 0).all())
        require(flat, "control_points", "z", "patches of the plane in z = 0")
        points = points[..., :2]
    weights = None if spline.weights is None else tuple(spline.weights.tolist())
    lengths = in_metres(points, unit)
    return GivenPatch(spline.degrees, spline.knots, tuple(lengths.tolist()), weights)


@lru_cache(_KEPT)
def _read(file: Path, _changed: int, _size: int) -> FileSplines:
    reader = {".json": json_splines, ".xml": xml_splines}.get(file.suffix.lower())
    if reader is None:
        raise InputError("file", str(file), "one that ends in .json or .xml")
    try:
        return reader(file.read_text("utf-8"))
    except (ValueError, LookupError, TypeError, AttributeError, SyntaxError, RecursionError):
        allowed = f"a whole {file.suffix} file of patches; it is not as its format has it"
        raise InputError("file", str(file), allowed) from None
