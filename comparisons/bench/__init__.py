"""Time and memory of assembly, solution and parallel runs, and of other programs: `cea bench`."""
