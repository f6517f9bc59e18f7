"""Geometry: the shapes scenes are made of, their meshes as plain arrays and as NURBS patches.

Independent of backends: returns :class:`cea.mesh.Mesh` and plain NURBS data, which backends read.
"""
