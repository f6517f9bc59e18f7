"""Stiff and extreme scenes against references: accurate, warned, refused, or wrong."""
