"""Base class of the figures of the paper: kinds of meshes, inputs, and tables of results."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from cea.arrays import Floats
from cea.contact.formulations import Formulation, Greville, Grid, NodeToSurface
from comparisons.study.session import Session
from meshes.shapes import Sector
from scenes.spec.body import Backend

Mesh = Literal["NURBS", "hexahedra", "tetrahedra", "none"]
BACKENDS: dict[Mesh, Backend] = {"NURBS": "iga", "hexahedra": "fe", "tetrahedra": "fe"}
"""Backend of each kind of mesh."""
MESHES: tuple[Mesh, ...] = tuple(BACKENDS)
MOST_LAGRANGE = 4  # highest degree of Lagrange elements
_FACET_GRID = 4  # grid points per direction on a facet

Row = dict[str, Any]
Tables = dict[str, list[Row]]


@dataclass(frozen=True)
class Figure(ABC):
    """A figure of the paper, or an additional study, on some kinds of meshes."""

    name: str  # number of the figure; a word for an additional study
    title: str
    meshes: tuple[Mesh, ...] = field(default=MESHES, kw_only=True)

    @abstractmethod
    def inputs(self, mesh: Mesh) -> Mapping[str, Any]:
        """Return everything that determines the results: scenes by label."""

    @abstractmethod
    def evaluate(self, mesh: Mesh, session: Session) -> Tables:
        """Return rows by name of table; collective. ``session.scene`` has the inputs."""


def quoted(
    what: str, paper: float | str | None, ours: float, unit: str = "", remark: str = ""
) -> Row:
    """Return a row of the table "numbers"; ``paper`` may be a number, words, or None."""
    return {"what": what, "paper": paper, "ours": float(ours), "unit": unit, "remark": remark}


def rows_of(columns: Mapping[str, Any]) -> list[Row]:
    """Return the rows of columns of equal length."""
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def as_lagrange(formulation: Formulation) -> Formulation:
    """Return the counterpart on Lagrange elements: nodes for Greville, a grid on each facet."""
    if isinstance(formulation, Greville):
        return NodeToSurface()
    return Grid(_FACET_GRID) if isinstance(formulation, Grid) else formulation


def polar_points(r: Floats, theta: Floats, z: float) -> Floats:
    """Return points at all radii (m) and angles (degrees), radius by radius, shape (n, 3)."""
    radius, angle = (part.ravel() for part in np.meshgrid(r, np.deg2rad(theta), indexing="ij"))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), z)])


def midpoints(low: float, high: float, n: int) -> Floats:
    """Return the midpoints of n equal parts of an interval."""
    return low + (high - low) * (np.arange(n) + 0.5) / n


def sector_points(sector: Sector, across: int, along: int, z: float) -> Floats:
    """Return points of a sector at the midpoints of equal parts of its radii and angles."""
    r = midpoints(sector.inner_radius, sector.outer_radius, across)
    return polar_points(r, midpoints(sector.start, sector.end, along), z)
