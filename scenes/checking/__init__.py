"""What a scene and its results must be read with, and a scene looked at before it is run."""
