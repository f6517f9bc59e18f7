"""Scenes and results written for other programs."""
