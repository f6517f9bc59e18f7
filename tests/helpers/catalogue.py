"""Scenes that come with the project, with the backends that all their bodies have meshes for."""

from scenes.spec.plain import scene_names, tables_of

FE_ONLY = {"ventilated_brake"}
"""Scenes of shapes that have no NURBS patches."""

MESHED = [
    (name, backend)
    for name in scene_names()
    for backend in ("fe", "iga")
    if all(backend in body["mesh"] for body in tables_of(name)["bodies"].values())
]
"""Names and backends."""
assert {name for name in scene_names() if (name, "iga") not in MESHED} == FE_ONLY
