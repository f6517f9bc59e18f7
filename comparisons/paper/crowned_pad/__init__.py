"""Steady sliding of a crowned pad: what each contact formulation makes of the equilibrium."""
