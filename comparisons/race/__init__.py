"""Run time beside shift-and-invert by scipy: `cea race`."""
