"""Eigenvalues with error bars: a scene refined on both backends until its modes hold their digits."""
