"""Converged modes of the disc and pad, on which both backends agree."""
