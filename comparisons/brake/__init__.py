"""Modes of the ventilated brake on a sequence of refined meshes."""
