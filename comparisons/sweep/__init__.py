"""Modes of a scene along one parameter: `cea sweep`."""
