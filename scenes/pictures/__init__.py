"""Bodies and contacts as grids of pyvista, and what is drawn of them."""
