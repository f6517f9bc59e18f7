"""Matrices in files of other programs: reading them, and telling which are symmetric."""
