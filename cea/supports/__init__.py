"""Boundary conditions of a body: supports, springs, pressures, forces."""
