"""Damping moves thresholds of flutter both ways: a mass between four walls, and its exact model."""
