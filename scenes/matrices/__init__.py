"""Matrices from files, and the pencil that a scene of matrices makes of them."""
