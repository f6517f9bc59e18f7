"""Applications on top of scenes: comparisons, studies, and the command line."""
