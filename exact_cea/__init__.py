"""Exact eigenvalues of model problems in frictional sliding contact, without a mesh.

All problems of continua have the weak form: find ``lambda``, ``u`` with

    lambda^2 (rho u, v) + (sigma(u), eps(v)) + <p g, g(v)> - <mu p g, [[v]].k> = 0  for all v,

``[[u]] = u^a - u^b``, ``g = [[u]].n``, n the outward unit normal of body a, k the direction of
the friction traction on a. Drum and blocks with sinusoidal friction have characteristic
functions in closed form, whose roots are counted by the argument principle. Blocks with constant
friction and the ring are solved by a graded Galerkin method of high degree, which also checks the
other two. Eigenvalues of lumped systems are roots of polynomials.
"""
