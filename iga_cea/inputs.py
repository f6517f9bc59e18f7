"""Input of a NURBS body checked before any work begins."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cea.errors import InputError
from iga_cea.collapse import collapsed_lines, face_is_collapsed
from iga_cea.multipatch import End
from iga_cea.patch import PatchGeometry, check_geometry

MAX_DEGREE = 8
"""Highest degree of a trial space."""


def check_patches(patches: Sequence[PatchGeometry], field: str) -> int:
    """Refuse patches that make no body; return their dimension."""
    if not patches:
        raise InputError(field, patches, "at least one patch")
    dims = {len(patch.degrees) for patch in patches}
    if len(dims) != 1 or not dims <= {2, 3}:
        raise InputError(field, sorted(dims), "patches of one dimension, 2 or 3")
    for number, patch in enumerate(patches):
        check_geometry(patch, f"{field}[{number}]")
    return dims.pop()


def checked_degree(
    degree: Sequence[int], patches: Sequence[PatchGeometry], field: str
) -> tuple[int, ...]:
    """Degrees of the trial space, none below that of the geometry."""
    dim = len(patches[0].degrees)
    if not _whole_numbers(degree, dim) or not all(1 <= q <= MAX_DEGREE for q in degree):
        raise InputError(field, degree, f"{dim} whole numbers from 1 to {MAX_DEGREE}")
    lowest = np.max([patch.degrees for patch in patches], axis=0)
    if np.any(np.asarray(degree) < lowest):
        allowed = f"at least {tuple(lowest.tolist())}, the degree of the geometry"
        raise InputError(field, degree, allowed)
    return tuple(int(q) for q in degree)


def checked_continuity(
    continuity: Sequence[int] | None, degree: tuple[int, ...], field: str
) -> tuple[int, ...]:
    """Continuity at inserted breaks, by default the highest."""
    if continuity is None:
        return tuple(q - 1 for q in degree)
    whole = _whole_numbers(continuity, len(degree))
    if not whole or not all(0 <= c < q for c, q in zip(continuity, degree, strict=True)):
        allowed = f"{len(degree)} whole numbers from 0 to the degree {degree} less 1"
        raise InputError(field, continuity, allowed)
    return tuple(int(c) for c in continuity)


def check_faces(
    faces: Mapping[str, Sequence[End]], patches: Sequence[PatchGeometry], dim: int, field: str
) -> None:
    """Refuse surfaces with no faces, with some that do not exist, or with collapsed ones."""
    collapsed = [collapsed_lines(patch.control_points) for patch in patches]
    for name, ends in faces.items():
        real = [0 <= p < len(patches) and 0 <= a < dim and s in (0, 1) for p, a, s in ends]
        if not real or not all(real) or len(set(ends)) != len(ends):
            allowed = f"different (patch below {len(patches)}, axis below {dim}, side 0 or 1)"
            raise InputError(f"{field}.{name}", tuple(ends), allowed)
        for patch, axis, side in ends:
            if face_is_collapsed(collapsed[patch], axis, side):
                allowed = "faces that are not collapsed to an edge or a point"
                raise InputError(f"{field}.{name}", (patch, axis, side), allowed)


def _whole_numbers(values: Any, count: int) -> bool:
    return len(values) == count and all(isinstance(v, int | np.integer) for v in values)
