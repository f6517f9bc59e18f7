"""Exact eigenvalues of frictional sliding contacts, found without any finite element or spline.

Weak form of every problem here: find ``lambda``, ``u`` with

    lambda^2 (rho u, v) + (sigma(u), eps(v)) + <p g, g(v)> - <mu p g, [[v]].k> = 0  for all v,

``[[u]] = u^a - u^b``, ``g = [[u]].n``, n the outward unit normal of body a, k the direction of
the friction traction on a. Drum and blocks with sinusoidal friction have characteristic
functions of closed form, whose roots are counted by the argument principle; blocks with constant
friction and the ring are solved by a graded Galerkin method of high order, which also checks the
others; lumped systems are roots of polynomials.
"""
