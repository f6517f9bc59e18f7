"""Geometry: the shapes scenes are made of, and builders of gmsh meshes and NURBS patches of them.

Knows no other room: returns gmsh models and plain NURBS data that the backends take in.
"""
