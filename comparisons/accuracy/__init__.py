"""Error of eigenvalues against run time, by exact eigenvalues: `cea study accuracy`."""
