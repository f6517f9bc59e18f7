"""What a scene file says: one module for each of its sections."""
