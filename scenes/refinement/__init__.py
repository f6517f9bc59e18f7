"""Refinement of scenes."""
