"""Grids of bodies and contacts for pyvista, and pictures of modes and scenes."""
