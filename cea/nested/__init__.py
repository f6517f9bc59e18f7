"""Error estimates of eigenvalues in a richer space: prolongation and inverse iteration."""
