"""Discretisations that lie inside each other: prolongation, errors of eigenvalues."""
