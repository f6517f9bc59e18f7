"""Stiffness and mass by this program and others, on the same body: `cea bench assembly`."""
