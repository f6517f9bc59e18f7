"""Ways to the eigenvalues of a window, a file each; each runs in a process of its own."""
