"""Eigenvalues with error bars: scenes refined on both backends until modes hold their digits."""
