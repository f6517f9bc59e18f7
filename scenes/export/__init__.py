"""Export of scenes and results for other programs."""
