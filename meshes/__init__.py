"""Geometry: the shapes scenes are made of, their meshes as plain arrays and as NURBS patches.

Knows no backend: hands out :class:`cea.mesh.Mesh` and plain NURBS data, which the backends take in.
"""
