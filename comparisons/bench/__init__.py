"""Time and memory of solution and parallel runs, and of other programs: `cea bench`."""
