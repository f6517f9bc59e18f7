"""Matrices of a Lagrange space, assembled from compiled scalar forms.

For scalar basis functions phi_n, one form with a tensor T gives

    K_ij = int T^ij_pq d_p phi_m d_q phi_n,    T^ij_pq = c_ipjq,

for the components i and j of an elastic solid (Hughes, The Finite Element Method, 2000, sec. 2.8
and 3.10; row m, column n; K_ji = K_ij^T). The same form with the stress as T is the geometric
stiffness, and with v v^T, v the velocity of a rotation, the convective stiffness. T is constant, or
given at the quadrature points. Every scalar matrix is combined with its transpose, so that matrices
are symmetric or skew to the last bit.

Forms are compiled once per element for all materials: material data are dolfinx Constants.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import ufl
from basix import make_quadrature
from basix.ufl import quadrature_element
from dolfinx.fem import Constant, Expression, Form, Function, form, functionspace
from dolfinx.fem.petsc import assemble_matrix, create_matrix
from scipy.sparse import bsr_array, csr_array

from cea.arrays import Floats
from cea.body import Density
from cea.material import Elasticity
from cea.matrices import destroy, distributed, local_part
from cea.motion import Rotation
from cea.petsc import PETSc
from cea.ranks import agreed

_JIT_OPTIONS = {"cffi_extra_compile_args": ["-O3", "-march=native"]}


class LagrangeMatrices:
    """Matrices of all dofs (full x full), PETSc AIJ, not cached; assembly is collective.

    ``V`` is a scalar Lagrange space (dolfinx), ``comm`` has the ranks of its mesh. By default the
    quadrature of the mass is exact on affine cells.
    """

    def __init__(self, V: Any, comm: Any, mass_quadrature: int | None = None) -> None:
        self.scalar, self._mesh, self.comm = V, V.mesh, comm
        self._mass_quadrature = mass_quadrature
        self._trial, self._test = ufl.TrialFunction(V), ufl.TestFunction(V)
        self._order = max(V.ufl_element().degree, V.mesh.geometry.cmaps[0].degree)
        self._is_simplex = V.mesh.basix_cell().name in ("triangle", "tetrahedron")

    @property
    def dim(self) -> int:
        """Dimension of space, 2 or 3."""
        return int(self._mesh.geometry.dim)

    def stiffness(self, elasticity: Elasticity) -> Any:
        """Return the elastic stiffness (N/m), symmetric."""
        every = range(self.dim)
        integral, x, put = self._gradients(2, elasticity.varies)
        matrix = create_matrix(integral)
        blocks: Floats = np.empty(0)
        for j in every:
            tensor = np.empty((self.dim, self.dim, *x.shape))  # i, p, q, points
            for q in every:
                gradient = np.zeros((self.dim, *x.shape))
                gradient[j, q] = 1.0
                with agreed(self.comm):
                    tensor[:, :, q] = elasticity.stress(gradient, x)
            for i in range(j + 1):
                put(tensor[i])
                rows, transposed = _integrated(integral, matrix)
                if not blocks.size:
                    blocks = np.empty((rows.nnz, self.dim, self.dim))
                blocks[:, i, j], blocks[:, j, i] = rows.data, transposed
                if i == j:
                    blocks[:, i, i] = 0.5 * (rows.data + transposed)
        destroy(matrix)
        return self._matrix(_coupled(rows, blocks))

    def mass(self, rho: Density) -> Any:
        """Return the consistent mass (kg), symmetric, without coupling of components."""
        rows, transposed = self._products(self._mass_quadrature, rho if callable(rho) else None)
        factor = 0.5 if callable(rho) else 0.5 * rho
        return self._of_each_component(rows, factor * (rows.data + transposed))

    def geometric_stiffness(self, elasticity: Elasticity, displacement: Floats) -> Any:
        """Return the geometric stiffness int sigma_ij d_i u . d_j v of a displacement (N/m)."""
        integral, x, put = self._gradients(3, varies=True)
        degree = self._degree(3)
        slopes = [self._at_points(ufl.grad(u), degree) for u in self._functions(displacement)]
        with agreed(self.comm):
            put(elasticity.stress(np.stack(slopes), x))
        rows, transposed = _scalar(integral)
        return self._of_each_component(rows, 0.5 * (rows.data + transposed))

    def gyroscopic(self, rho: float, rotation: Rotation) -> Any:
        """Return Y at 1 rad/s (:mod:`cea.motion`), kg, skew."""
        degree = 2 * self._order + 1
        rows, transposed = self._transport(rotation, degree)
        skew = rho * (rows.data - transposed)
        if rotation.coriolis:
            return self._of_each_component(rows, skew)
        products, mirrored = self._products(degree)
        mass = rho * (products.data + mirrored)
        return self._matrix(
            _coupled(rows, _times(skew, np.eye(self.dim)) - _times(mass, rotation.spin(self.dim)))
        )

    def convective(self, rho: float, rotation: Rotation) -> Any:
        """Return Z of :mod:`cea.motion`, kg, symmetric."""
        v, degree = self._velocity(rotation), 2 * self._order + 2
        along = [ufl.dot(v, ufl.grad(each)) for each in (self._trial, self._test)]
        rows, transposed = _scalar(self._form(along[0] * along[1], degree))
        squares = 0.5 * rho * (rows.data + transposed)
        if rotation.coriolis:
            return self._of_each_component(rows, squares)
        spin, eye = rotation.spin(self.dim), np.eye(self.dim)
        of_trial, of_test = self._transport(rotation, degree)
        skew = rho * (of_trial.data - of_test)
        products, mirrored = self._products(degree)
        mass = 0.5 * rho * (products.data + mirrored)
        # R u = v . grad u - W u with the skew matrix W.
        blocks = _times(squares, eye) + _times(skew, spin) + _times(mass, spin.T @ spin)
        return self._matrix(_coupled(rows, blocks))

    def _gradients(
        self, factors: int, varies: bool
    ) -> tuple[Form, Floats, Callable[[Floats], None]]:
        """Return the form int T grad phi_n . grad phi_m, the points of T, and its setter.

        The integrand has ``factors`` gradients, those in T included. T is needed at points (m),
        (dim, n), and set as (dim, dim, n): quadrature points if it varies, else one arbitrary
        point. Gradients have one degree less than functions, in boxes along one direction only.
        """
        degree, shape = self._degree(factors), (self.dim, self.dim)
        if varies:
            cell, mesh = self._mesh.basix_cell(), self._mesh
            element = quadrature_element(cell, value_shape=shape, degree=degree)
            tensor: Any = Function(functionspace(mesh, element))
            at = tensor.function_space.dofmap.list
            values = tensor.x.array.reshape(-1, *shape)
            x = self._at_points(ufl.SpatialCoordinate(mesh), degree)

            def put(numbers: Floats) -> None:
                values[at.ravel()] = np.moveaxis(numbers, -1, 0)
        else:
            tensor, x = Constant(self._mesh, np.zeros(shape)), np.zeros((self.dim, 1))

            def put(numbers: Floats) -> None:
                tensor.value[:] = numbers[..., 0]

        integrand = ufl.inner(ufl.dot(tensor, ufl.grad(self._trial)), ufl.grad(self._test))
        return self._form(integrand, degree), x, put

    def _degree(self, factors: int) -> int:
        """Return the quadrature degree of a product of ``factors`` gradients."""
        return factors * (self._order - self._is_simplex)

    def _at_points(self, expression: Any, degree: int) -> Floats:
        """Return a vector at the quadrature points of a degree, (dim, n)."""
        points, _ = make_quadrature(self._mesh.basix_cell(), degree)
        cells = self._mesh.topology.index_map(self._mesh.topology.dim)
        every = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
        found = Expression(expression, points).eval(self._mesh, every)
        return found.reshape(-1, self.dim).T

    def _products(
        self, degree: int | None = None, weight: Callable[[Floats], Floats] | None = None
    ) -> tuple[csr_array, Floats]:
        """Return int w phi_m phi_n, w = 1 or a function of x, by default exact on affine cells."""
        degree, integrand = 2 * self._order if degree is None else degree, self._trial * self._test
        if weight is not None:
            element = quadrature_element(self._mesh.basix_cell(), degree=degree)
            w = Function(functionspace(self._mesh, element))
            x = self._at_points(ufl.SpatialCoordinate(self._mesh), degree)
            w.x.array[w.function_space.dofmap.list.ravel()] = weight(x)
            integrand *= w
        return _scalar(self._form(integrand, degree))

    def _transport(self, rotation: Rotation, degree: int) -> tuple[csr_array, Floats]:
        """Return int phi_m v . grad phi_n with the velocity v of a rotation."""
        along = ufl.dot(self._velocity(rotation), ufl.grad(self._trial))
        return _scalar(self._form(along * self._test, degree))

    def _form(self, integrand: Any, degree: int) -> Form:
        measure = ufl.dx(self._mesh, metadata={"quadrature_degree": degree})
        return form(integrand * measure, jit_options=dict(_JIT_OPTIONS))

    def _velocity(self, rotation: Rotation) -> Any:
        """Return the velocity a x r of a rotation at 1 rad/s (m)."""
        spin = Constant(self._mesh, rotation.spin(self.dim))
        origin = Constant(self._mesh, np.asarray(rotation.origin[: self.dim], dtype=float))
        return ufl.dot(spin, ufl.SpatialCoordinate(self._mesh) - origin)

    def _functions(self, displacement: Floats) -> list[Function]:
        """Return the components of a displacement of all dofs as functions."""
        first, last = self.scalar.dofmap.index_map.local_range
        own = displacement[self.dim * first : self.dim * last].reshape(-1, self.dim)
        functions = []
        for component in own.T:
            u = Function(self.scalar)
            u.x.array[: last - first] = component
            u.x.scatter_forward()
            functions.append(u)
        return functions

    def _of_each_component(self, rows: csr_array, values: Floats) -> Any:
        """Return a matrix with the same scalar entries in each component."""
        count, columns = rows.shape
        scalar = csr_array((values, rows.indices, rows.indptr), shape=rows.shape)
        repeated = csr_array(scalar[np.repeat(np.arange(count), self.dim)])
        component = np.repeat(np.tile(np.arange(self.dim), count), np.diff(repeated.indptr))
        entries = (repeated.data, self.dim * repeated.indices + component, repeated.indptr)
        return self._matrix(csr_array(entries, shape=(self.dim * count, self.dim * columns)))

    def _matrix(self, rows: csr_array) -> Any:
        """Return the PETSc AIJ matrix of the rows of all ranks."""
        return distributed(rows, rows.shape, self.comm, shared=True)


def _scalar(integral: Form) -> tuple[csr_array, Floats]:
    """Assemble a scalar form; return what :func:`_integrated` returns."""
    matrix = create_matrix(integral)
    found = _integrated(integral, matrix)
    destroy(matrix)
    return found


def _integrated(integral: Form, matrix: Any) -> tuple[csr_array, Floats]:
    """Return this rank's rows of a scalar form, and values of its transpose at these entries."""
    matrix.zeroEntries()
    assemble_matrix(matrix, integral)
    matrix.assemble()
    transpose = matrix.transpose(PETSc.Mat())
    found = local_part(matrix), local_part(transpose).data
    destroy(transpose)
    return found


def _times(values: Floats, block: Floats) -> Floats:
    """Return each value times a block (dim, dim), shape (n, dim, dim)."""
    return values[:, None, None] * block


def _coupled(pattern: csr_array, blocks: Floats) -> csr_array:
    """Return rows of all components from a block (dim, dim) per nonzero of scalar rows."""
    rows, columns = pattern.shape
    shape = (rows * blocks.shape[1], columns * blocks.shape[2])
    return csr_array(bsr_array((blocks, pattern.indices, pattern.indptr), shape=shape).tocsr())
