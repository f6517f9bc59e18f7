"""Degrees of the quadrature of each integral, exact on affine cells."""

from typing import Any


def _order(V: Any) -> int:
    """Polynomial order that quadrature must resolve: of the space or of the geometry."""
    mesh = V.mesh
    return max(V.ufl_element().basix_element.degree, mesh.geometry.cmaps[0].degree)


def _is_simplex(V: Any) -> bool:
    return V.mesh.basix_cell().name in ("interval", "triangle", "tetrahedron")


def stiffness_degree(V: Any) -> int:
    """Quadrature degree of the stiffness, exact on affine cells.

    Products of gradients have degree 2 (q - 1) on simplices; on tensor cells they keep degree 2 q
    along one direction.
    """
    q = _order(V)
    return 2 * (q - 1) if _is_simplex(V) else 2 * q


def mass_degree(V: Any) -> int:
    """Quadrature degree of products of basis functions, exact on affine cells and facets."""
    return 2 * _order(V)


def transport_degree(V: Any) -> int:
    """Quadrature degree of a function times the derivative of another along the rotation."""
    return mass_degree(V) + 1


def geometric_degree(V: Any) -> int:
    """Quadrature degree of products of three gradients, exact on affine cells."""
    q = _order(V)
    return 3 * (q - 1) if _is_simplex(V) else 3 * q


def pressure_degree(V: Any) -> int:
    """Quadrature degree of pressures, exact: the normal times the area element is a polynomial.

    Of geometry of degree g, one tangent contributes g - 1 along each direction; the other, in
    space, g - 1 on triangles and g on squares.
    """
    mesh = V.mesh
    q, g = V.ufl_element().basix_element.degree, mesh.geometry.cmaps[0].degree
    second = {2: 0, 3: g - 1 if _is_simplex(V) else g}[mesh.geometry.dim]
    return q + g - 1 + second
