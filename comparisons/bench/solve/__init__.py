"""This eigenvalue driver beside others on the same matrices: `cea bench solve`."""
