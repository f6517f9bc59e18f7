"""Kinds of meshes that the figures are made on."""

from typing import Literal

from scenes.spec.body import Backend

Family = Literal["NURBS", "hexahedra", "tetrahedra"]

FAMILIES: dict[Backend, tuple[Family, ...]] = {
    "iga": ("NURBS",),
    "fe": ("hexahedra", "tetrahedra"),
}
"""Kinds of meshes that a backend has."""

BACKEND_OF: dict[Family, Backend] = {
    family: backend for backend, families in FAMILIES.items() for family in families
}
"""The backend of each kind of mesh."""
