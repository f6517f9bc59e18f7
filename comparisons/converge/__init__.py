"""Eigenvalues with error bars, by refining a scene on both backends: `cea converge`."""
