"""Mesh files as plain arrays: a reader for each format, and bodies made from their parts."""
