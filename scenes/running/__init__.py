"""Runs of scenes, with one module for each kind of analysis."""
