"""Scenes: files that describe bodies in contact, and what turns one into a result."""
