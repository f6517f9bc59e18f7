"""Scenes, runs, comparisons and reports: the room that knows all others."""
