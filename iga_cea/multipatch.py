"""Patches joined to one body: numbering of scalar dofs and partition over ranks.

Control points that coincide, on joined faces and along collapsed edges, share one scalar dof.

Elements of all patches, in order, are divided into contiguous ranges, one per rank; within a patch
they are numbered so that cuts are normal to the parameter with most elements. A scalar dof belongs
to the rank of the element in the middle of its support, the lowest if patches share it, and the
dofs of a rank are numbered contiguously. All ranks store the integer connectivity, but only their
own matrix rows.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product

import numpy as np

from cea.arrays import Floats, Ints, connected
from iga_cea.collapse import coinciding, face_is_collapsed
from iga_cea.face import PatchFace
from iga_cea.joints import joined_dofs
from iga_cea.patch import Patch

End = tuple[int, int, int]


@dataclass(frozen=True)
class Multipatch:
    """Joined patches with their dof numbers."""

    patches: tuple[Patch, ...]  # the refined patches
    # scalar dof of each control point of each patch, in the shape of its net
    dofs: tuple[Ints, ...]
    dof_ranges: Ints  # first scalar dof of each rank, and the end of the last, shape (ranks + 1,)

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.patches[0].dim

    @property
    def num_scalar_dofs(self) -> int:
        """Number of scalar dofs on all ranks."""
        return int(self.dof_ranges[-1])

    @property
    def control_points(self) -> Floats:
        """Control point of each scalar dof (m), shape (num_scalar_dofs, dim)."""
        points = np.empty((self.num_scalar_dofs, self.dim))
        for patch, dofs in zip(self.patches, self.dofs, strict=True):
            points[dofs] = patch.control_points
        return points

    def faces(self, ends: Sequence[End]) -> list[PatchFace]:
        """Return faces (patch, axis, side) with their global scalar dofs."""
        return [PatchFace.of(self.patches[end[0]], self.dofs[end[0]], end) for end in ends]


def join(patches: Sequence[Patch], ranks: int, field: str) -> Multipatch:
    """Join patches where their faces coincide."""
    sizes = [patch.weights.size for patch in patches]
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    copies = [
        offset + np.arange(patch.weights.size).reshape(patch.shape)
        for offset, patch in zip(offsets, patches, strict=False)
    ]
    scalar = _merge(patches, copies, int(offsets[-1]), field)

    of_copies, elements = _middle_elements(patches)
    middle = np.full(scalar.max() + 1, elements)
    np.minimum.at(middle, scalar, of_copies)
    element_ranges = np.arange(ranks + 1) * elements // ranks
    owner = np.searchsorted(element_ranges, middle, side="right") - 1

    order = np.argsort(owner, kind="stable")
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    return Multipatch(
        patches=tuple(patches),
        dofs=tuple(number[scalar[copy]] for copy in copies),
        dof_ranges=np.searchsorted(owner[order], np.arange(ranks + 1)),
    )


def _merge(patches: Sequence[Patch], copies: Sequence[Ints], count: int, field: str) -> Ints:
    """Return the scalar dof of each copy of a control point, shape (count,)."""
    faces = [
        PatchFace.of(patch, copies[k], (k, axis, side))
        for k, patch in enumerate(patches)
        for axis, side in product(range(patch.dim), (0, 1))
        if not face_is_collapsed(patch.collapsed, axis, side)
    ]
    points = [
        coinciding(patch.collapsed, copy) for patch, copy in zip(patches, copies, strict=True)
    ]
    pairs = np.concatenate([joined_dofs(faces, field), *points])
    label = connected(pairs, count)
    # Number components by their first copy, to change the order as little as possible.
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    rank_of_label = np.empty(len(first), dtype=np.int64)
    rank_of_label[np.argsort(first)] = np.arange(len(first))
    return rank_of_label[inverse]


def _middle_elements(patches: Sequence[Patch]) -> tuple[Ints, int]:
    """Return the element in the middle of each control point's support, and their number.

    The parameter with most elements varies slowest, which makes partition boundaries small.
    """
    middle, offset = [], 0
    for patch in patches:
        along = []
        for firsts, degree, n in zip(
            patch.first_functions, patch.degrees, patch.shape, strict=True
        ):
            # The support of function i has the spans whose first function is i - degree to i.
            lowest = np.searchsorted(firsts, np.arange(n) - degree)
            highest = np.searchsorted(firsts, np.arange(n), side="right") - 1
            along.append((lowest + highest) // 2)
        spans = patch.spans
        numbers = np.meshgrid(*along, indexing="ij")
        # On ties the first varies fastest: cuts normal to it would duplicate shared work.
        order = sorted(range(len(spans)), key=lambda axis: (-spans[axis], -axis))
        number = np.ravel_multi_index(
            [numbers[axis] for axis in order], [spans[axis] for axis in order]
        )
        middle.append(offset + number.ravel())
        offset += reduce(lambda a, b: a * b, spans)
    return np.concatenate(middle), offset
