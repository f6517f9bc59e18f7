"""Fixtures shared by all tests."""

import cea  # noqa: F401  (brings the PETSc stack into a safe order before any test imports it)
