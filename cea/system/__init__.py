"""Bodies and contacts coupled: matrices of the whole, stresses over its contacts."""
