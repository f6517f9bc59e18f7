"""Contact: interfaces, formulations, laws, and their matrices."""
