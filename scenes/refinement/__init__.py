"""Scenes on finer meshes."""
