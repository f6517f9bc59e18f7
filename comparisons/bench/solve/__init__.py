"""The eigenvalue driver beside other methods on the same matrices: `cea bench solve`."""
