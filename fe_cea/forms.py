"""Weak forms of linear elasticity on a Lagrange space, each with its own quadrature.

Numbers are dolfinx Constants: a form is compiled once for each element, whatever the material.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type
from dolfinx.fem import Constant, Form, form

from cea.arrays import Floats
from cea.material import IsotropicMaterial
from cea.rotation import Rotation
from cea.supports.boundary import Pressure, Spring

JIT_OPTIONS = {"cffi_extra_compile_args": ["-O3", "-march=native"]}


def compiled(expression: Any) -> Form:
    """Compile a UFL form for this machine."""
    return form(expression, jit_options=dict(JIT_OPTIONS))


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


def pressure_degree(V: Any) -> int:
    """Quadrature degree of pressures, exact: the normal times the area element is a polynomial.

    Of geometry of degree g, one tangent contributes g - 1 along each direction; the other, in
    space, g - 1 on triangles and g on squares.
    """
    mesh = V.mesh
    q, g = V.ufl_element().basix_element.degree, mesh.geometry.cmaps[0].degree
    second = {2: 0, 3: g - 1 if _is_simplex(V) else g}[mesh.geometry.dim]
    return q + g - 1 + second


def stiffness_form(
    V: Any, material: IsotropicMaterial, springs: Iterable[tuple[Spring, int]], facet_tags: Any
) -> Form:
    """Elastic stiffness with springs, N/m.

    Parameters
    ----------
    V
        Vector Lagrange space (dolfinx).
    material
        Material.
    springs
        Springs with the facet tags of their surfaces.
    facet_tags
        Facet tags (dolfinx).
    """
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    dx = ufl.dx(metadata={"quadrature_degree": stiffness_degree(V)})
    a = ufl.inner(_stress(u, V, material), ufl.sym(ufl.grad(v))) * dx
    return compiled(sum(_spring_integrals(V, springs, facet_tags), a))


def _stress(u: Any, V: Any, material: IsotropicMaterial) -> Any:
    """Stress of a displacement (N/m^2)."""
    lam, mu = (Constant(V.mesh, default_scalar_type(value)) for value in material.lame)
    dim = V.mesh.geometry.dim
    return lam * ufl.div(u) * ufl.Identity(dim) + 2 * mu * ufl.sym(ufl.grad(u))


def geometric_form(displacement: Any, material: IsotropicMaterial) -> Form:
    """Stiffness int sigma_ij d_i u . d_j v that stresses of a displacement make, N/m.

    Parameters
    ----------
    displacement
        Function of a vector Lagrange space (dolfinx), m.
    material
        Material.
    """
    V = displacement.function_space
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    stress = _stress(displacement, V, material)
    degree = geometric_degree(V)
    dx = ufl.dx(metadata={"quadrature_degree": degree})
    return compiled(ufl.inner(ufl.grad(u) * stress, ufl.grad(v)) * dx)


def geometric_degree(V: Any) -> int:
    """Quadrature degree of products of three gradients, exact on affine cells."""
    q = _order(V)
    return 3 * (q - 1) if _is_simplex(V) else 3 * q


def spring_form(V: Any, springs: Iterable[tuple[Spring, int]], facet_tags: Any) -> Form:
    """What springs, each with the facet tag of its surface, are of the stiffness, N/m."""
    first, *others = _spring_integrals(V, springs, facet_tags)
    return compiled(sum(others, first))


def _spring_integrals(
    V: Any, springs: Iterable[tuple[Spring, int]], facet_tags: Any
) -> Iterator[Any]:
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    ds = _facet_measure(V, facet_tags, mass_degree(V))
    for spring, tag in springs:
        k = Constant(V.mesh, np.asarray(spring.stiffness, dtype=default_scalar_type))
        yield sum(k[i] * u[i] * v[i] for i in range(V.mesh.geometry.dim)) * ds(tag)


def mass_form(V: Any, rho: float, degree: int | None = None) -> Form:
    """Consistent mass of density ``rho`` (kg/m^3) by a quadrature of a degree, by default exact."""
    density = Constant(V.mesh, default_scalar_type(rho))
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    dx = ufl.dx(metadata={"quadrature_degree": mass_degree(V) if degree is None else degree})
    return compiled(density * ufl.inner(u, v) * dx)


def transport_degree(V: Any) -> int:
    """Quadrature degree of a function times the derivative of another along the rotation."""
    return mass_degree(V) + 1


def gyroscopic_form(V: Any, rho: float, rotation: Rotation) -> Form:
    """Twice int rho v . R u of a rotation (:mod:`cea.rotation`), whose skew part is Y, kg."""
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    density = Constant(V.mesh, default_scalar_type(2 * rho))
    dx = ufl.dx(metadata={"quadrature_degree": transport_degree(V)})
    return compiled(density * ufl.inner(_transported(u, rotation), v) * dx)


def convective_form(V: Any, rho: float, rotation: Rotation) -> Form:
    """Z = int rho R v . R u of a rotation (:mod:`cea.rotation`), kg."""
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    density = Constant(V.mesh, default_scalar_type(rho))
    dx = ufl.dx(metadata={"quadrature_degree": transport_degree(V) + 1})
    return compiled(density * ufl.inner(_transported(u, rotation), _transported(v, rotation)) * dx)


def _transported(u: Any, rotation: Rotation) -> Any:
    """R u: the derivative along the rotation."""
    mesh = u.ufl_function_space().mesh
    dim = mesh.geometry.dim
    spin = Constant(mesh, np.asarray(rotation.spin(dim), dtype=default_scalar_type))
    origin = Constant(mesh, np.asarray(rotation.origin[:dim], dtype=default_scalar_type))
    along = ufl.dot(ufl.grad(u), ufl.dot(spin, ufl.SpatialCoordinate(mesh) - origin))
    return along if rotation.coriolis else along - ufl.dot(spin, u)


def pressure_form(V: Any, pressures: Iterable[tuple[Pressure, int]], facet_tags: Any) -> Form:
    """Forces of pressures, each with the facet tag of its surface, N."""
    mesh = V.mesh
    v, n = ufl.TestFunction(V), ufl.FacetNormal(mesh)
    ds = _facet_measure(V, facet_tags, pressure_degree(V))
    terms = [
        -Constant(mesh, default_scalar_type(pressure.value)) * ufl.inner(n, v) * ds(tag)
        for pressure, tag in pressures
    ]
    return compiled(sum(terms[1:], terms[0]))


def traction_form(V: Any, traction: Floats, tag: int, facet_tags: Any) -> Form:
    """Forces of a uniform traction (N/m^2), shape (dim,), on the surface of a facet tag, N."""
    value = Constant(V.mesh, np.asarray(traction, dtype=default_scalar_type))
    ds = _facet_measure(V, facet_tags, mass_degree(V))
    return compiled(ufl.inner(value, ufl.TestFunction(V)) * ds(tag))


def body_force_form(V: Any, force: Floats) -> Form:
    """Forces of a force on every part (N/m^3), shape (dim,), N."""
    value = Constant(V.mesh, np.asarray(force, dtype=default_scalar_type))
    dx = ufl.dx(metadata={"quadrature_degree": mass_degree(V)})
    return compiled(ufl.inner(value, ufl.TestFunction(V)) * dx)


def _facet_measure(V: Any, facet_tags: Any, degree: int) -> Any:
    return ufl.Measure(
        "ds",
        domain=V.mesh,
        subdomain_data=facet_tags,
        metadata={"quadrature_degree": degree},
    )
