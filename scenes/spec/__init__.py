"""Dataclasses of scene files, one module for each section, and their checks."""
