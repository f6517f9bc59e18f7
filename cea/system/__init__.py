"""Coupled bodies and contacts: matrices of the system, steady sliding, stresses."""
