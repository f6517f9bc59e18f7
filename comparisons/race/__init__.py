"""Run time beside shift-and-invert by scipy: `cea bench matrices`."""
