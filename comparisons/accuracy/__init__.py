"""Error of flutter eigenvalues against run time, beside exact lists: `cea study accuracy`."""
