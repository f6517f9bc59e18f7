"""Checks of scenes and results: warnings, skipped stages, memory, inspection before a run."""
