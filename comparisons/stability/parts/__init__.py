"""What cases are made of: runs, ways to run, scenes, references, problems and their answers."""
