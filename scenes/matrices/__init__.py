"""Matrices read from files, and the pencil of a scene of matrices."""
