"""The matrices that every method solves: disc_pad on tetrahedra, kept in files."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cea.eigen.pencil import Matrices, Pencil
from cea.errors import InputError
from cea.petsc import PETSc
from scenes.running.system import coupled
from scenes.spec.reading import Scene, load_scene

SCENE = "disc_pad"
SIZES: Mapping[str, Mapping[str, tuple[int, int, int]]] = {
    "tiny": {"pad": (2, 3, 1), "disc": (3, 16, 1)},
    "small": {"pad": (4, 7, 2), "disc": (6, 36, 1)},
    "medium": {"pad": (7, 12, 4), "disc": (9, 60, 2)},
    "large": {"pad": (9, 16, 5), "disc": (16, 120, 3)},
    "million": {"pad": (16, 28, 9), "disc": (30, 222, 5)},
}
"""Boxes of each body along r, theta and z, six quadratic tetrahedra each."""
MAX_FREQUENCY = 27e3
"""End of the window (Hz)."""
_NAMES = ("stiffness", "mass", "friction")


def scene_of_size(size: str) -> Scene:
    """The scene on tetrahedra.

    Raises
    ------
    InputError
        When there is no such size.
    """
    if size not in SIZES:
        raise InputError("size", size, f"one of {', '.join(SIZES)}")
    changes: dict[str, Any] = {"analysis.max_frequency": MAX_FREQUENCY}
    for body, boxes in SIZES[size].items():
        changes[f"bodies.{body}.mesh.fe.cell"] = "tetrahedron"
        changes[f"bodies.{body}.mesh.fe.elements"] = list(boxes)
    return load_scene(SCENE, backend="fe").change(changes)


def write_matrices(scene: Scene, folder: Path) -> int:
    """Write S, M and F of K = S - F, PETSc binary; the number of unknowns."""
    system, _, _ = coupled(scene)
    pencil = system.pencil()
    matrices = pencil.at()
    if matrices.multipliers is not None or matrices.unsymmetric is None or matrices.quadratic:
        raise InputError("scene", scene.name, "a penalty with friction, without damping")
    _write(matrices, folder)
    return matrices.size


def _write(matrices: Matrices, folder: Path) -> None:
    assert matrices.unsymmetric is not None
    matrices.unsymmetric.scale(-1.0)
    parts = (matrices.stiffness, matrices.mass, matrices.unsymmetric)
    for name, matrix in zip(_NAMES, parts, strict=True):
        viewer: Any = PETSc.Viewer().createBinary(str(folder / name), "w", comm=matrix.comm)
        matrix.view(viewer)
        viewer.destroy()


def _read(folder: Path) -> tuple[Any, Any, Any]:
    parts = list[Any]()
    for name in _NAMES:
        viewer: Any = PETSc.Viewer().createBinary(str(folder / name), "r")
        parts.append(PETSc.Mat().load(viewer))
        viewer.destroy()
    for symmetric in parts[:2]:
        symmetric.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    S, M, F = parts
    return S, M, F


@dataclass(frozen=True)
class Problem:
    """Matrices K = S - F and M, and what is asked of a method.

    Parameters
    ----------
    stiffness, mass, friction
        S, M and F, PETSc AIJ.
    top
        End of the window, of kappa = -lambda^2 (1/s^2).
    wanted
        Eigenvalues to be found; None where nobody knows, and the method must tell.
    """

    stiffness: Any
    mass: Any
    friction: Any
    top: float
    wanted: int | None

    @classmethod
    def read(cls, folder: Path, wanted: int | None) -> "Problem":
        """Matrices that :func:`write_matrices` wrote; collective."""
        top = (2 * np.pi * MAX_FREQUENCY) ** 2
        return cls(*_read(folder), top, wanted)

    @property
    def shift(self) -> float:
        """The middle of the window, where every method that shifts does so."""
        return 0.5 * self.top

    @property
    def count(self) -> int:
        """How many eigenvalues are wanted of a method that must be told.

        Raises
        ------
        InputError
            When that was not told.
        """
        if self.wanted is None:
            raise InputError("wanted", None, "a number of eigenvalues")
        return self.wanted

    def pencil(self) -> Pencil:
        """What this program's driver takes."""
        return Pencil.of(self.stiffness, self.mass, self.friction)

    def unsymmetric(self) -> Any:
        """K, a new matrix."""
        K = self.stiffness.copy()
        K.axpy(-1.0, self.friction, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        return K

    def shifted(self) -> Any:
        """K - shift M, a new matrix."""
        K = self.unsymmetric()
        K.axpy(-self.shift, self.mass, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        return K
