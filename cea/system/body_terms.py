"""Terms of the pencil from a body: stiffness and mass, damping and rotation.

With the path of the body in a scene, ``bodies.<name>``, the parameters are ``.material.E`` and
``.rho``, ``.damping.alpha`` and ``.beta``, ``.rotation.rate``, and that of modal damping.

Damping that rotates with its body adds circulatory terms to the stiffness (:mod:`cea.motion`).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from cea.arrays import Floats
from cea.body import Body
from cea.eigen.block_products import times
from cea.eigen.coefficients import CONSTANT, Coefficient, Dependence, Parameter
from cea.eigen.pencil import Role, Term
from cea.eigen.unformed import Circulatory, LowRank, UnformedTerm
from cea.material import Elasticity
from cea.matrices import (
    applied,
    block_diagonal,
    destroy,
    distributed,
    identity,
    one_below_the_other,
    side_by_side,
    zeros,
)
from cea.motion import Motion, Rotation
from cea.petsc import Mat, PETSc

if TYPE_CHECKING:  # imported only if modes are damped
    from cea.system.modal_damping import DampedModes


@dataclass(frozen=True)
class BodyTerms:
    """Terms of the pencil from a body, each computed once."""

    # the body
    name: str
    body: Body
    motion: Motion  # damping and rotation
    with_mass: bool  # whether the pencil has mass and damping
    # number of unknowns on this rank and on all ranks, of each body in order
    sizes: tuple[tuple[int, int], ...]
    number: int  # index of this body

    @property
    def path(self) -> str:
        """Path of the body in a scene."""
        return f"bodies.{self.name}"

    @property
    def rows(self) -> slice:
        """Range of the body's unknowns among those of this rank."""
        ends = np.cumsum([0, *(local for local, _ in self.sizes)])
        return slice(*ends[self.number : self.number + 2])

    @cached_property
    def pieces(self) -> tuple[Term | UnformedTerm[Circulatory], ...]:
        """Terms of K and M, rotation and Rayleigh damping."""
        own: list[Term | UnformedTerm[Circulatory]] = [*self._of_body()]
        if self.body.material.entries and self._constants:
            own += self._of_constants()
        if self.motion.rotation is not None:
            own += self._of_rotation(self.motion.rotation)
        if self.motion.circulates:
            own += self._carried()
        return tuple(own)

    @cached_property
    def modal(self) -> tuple[UnformedTerm[LowRank], ...]:
        """Terms of modal damping."""
        if self.motion.modal is None or not self.with_mass:
            return ()
        modes = self._damped_modes
        images = np.zeros((sum(local for local, _ in self.sizes), len(modes.weights)))
        images[self.rows] = modes.images
        return (UnformedTerm(LowRank(images, modes.weights), self._modal_ratio),)

    @cached_property
    def _constants(self) -> Mapping[str, float]:
        """Material constants that are parameters, by name.

        Empty for solids with several constants if damping is modal or rotates with the body.
        """
        motion, constants = self.motion, self.body.material.constants
        unknown = motion.circulates or motion.modal is not None
        return {} if unknown and "E" not in constants else constants

    def parameters(self) -> Iterator[Parameter]:
        """Yield the parameters of the body."""
        path, motion = self.path, self.motion
        fixed = motion.modal is not None  # modes depend on the material
        convective = motion.rotation is not None and motion.rotation.convective_stiffness
        for name, value in self._constants.items():
            positive, unit = name[0] in "EG", "1" if name[0] == "n" else "N/m^2"
            own = f"{path}.material.{name}"
            signs = {"positive": positive, "signed": not positive}
            yield Parameter(own, value, unit, fixed=fixed, **signs)
        if self.with_mass or motion.circulates or convective:
            own, rho = f"{path}.material.rho", float(self.body.material.rho or 0)
            yield Parameter(own, rho, "kg/m^3", positive=True, fixed=fixed)
        if motion.damping is not None:
            yield Parameter(f"{path}.damping.alpha", motion.damping.alpha, "1/s")
            yield Parameter(f"{path}.damping.beta", motion.damping.beta, "s")
        if motion.modal is not None:
            field, value = motion.modal.parameter
            yield Parameter(f"{path}.damping.modal.{field}", value)
        if motion.rotation is not None:
            yield Parameter(f"{path}.rotation.rate", motion.rotation.rate, "rad/s")

    def strain(self, x: Any) -> Floats | None:
        """Return the displacement beta Omega M^-1 B u, whose elastic forces are those of damping.

        ``x`` (m) are all unknowns, PETSc vector; the result is at the body's dofs on this rank.
        None without rotating stiffness damping.
        """
        damping, rotation = self.motion.damping, self.motion.rotation
        if damping is None or rotation is None or not damping.beta * rotation.rate:
            return None
        term = self.pieces[-1]
        assert not isinstance(term, Term)
        free = term.piece.inner(x.array_r[:, None])[:, 0]
        return damping.beta * rotation.rate * applied(self.body.expansion, free)

    def placed(self, matrix: Mat, *, rows: bool = True, columns: bool = True) -> Mat:
        """Return a matrix of the body padded with zeros for other bodies: rows, columns or both.

        With a single body it is the matrix itself.
        """
        if len(self.sizes) == 1:
            return matrix
        sizes: Any = matrix.getSizes()
        own_rows, own_columns = sizes
        blocks = [
            zeros(size if rows else own_rows, size if columns else own_columns, matrix.comm)
            for size in self.sizes
        ]
        others = blocks.copy()
        blocks[self.number] = matrix
        if rows and columns:
            whole = block_diagonal(blocks).convert("aij")
        else:
            whole = (one_below_the_other if rows else side_by_side)(blocks)
        destroy(*others)
        return whole

    @property
    def _stiffness(self) -> Coefficient:
        """Coefficient of K: Young's modulus relative to its value, or 1 if it is fixed."""
        if "E" not in self._constants or self.motion.modal is not None:
            return CONSTANT
        return Coefficient({f"{self.path}.material.E": (self._constants["E"], 1.0)})

    @property
    def _mass(self) -> Coefficient:
        """Coefficient of M: density relative to its value, or 1 if it is fixed."""
        if self.motion.modal is not None:
            return CONSTANT
        rho = float(self.body.material.rho or 0)
        return Coefficient({f"{self.path}.material.rho": (rho, 1.0)})

    @property
    def _modal_ratio(self) -> Coefficient:
        """Coefficient of modal damping: the ratio, or the factor on the table of ratios."""
        assert self.motion.modal is not None
        field, _ = self.motion.modal.parameter
        return Coefficient({f"{self.path}.damping.modal.{field}": (1.0, 1.0)})

    def _of_body(self) -> Iterator[Term]:
        """Yield K, its springs, M and Rayleigh damping."""
        body, path = self.body, self.path
        pieces: list[tuple[Role, Mat, Coefficient]]
        pieces = [("stiffness", body.elastic_stiffness(), self._stiffness)]
        if (springs := body.spring_stiffness()) is not None:
            pieces.append(("stiffness", springs, CONSTANT))
        if self.with_mass:
            pieces.append(("mass", body.mass(), self._mass))
        for role, own, coefficient in pieces:
            matrix = self.placed(own)
            yield Term(role, matrix, coefficient)
            if self.with_mass and self.motion.damping is not None:
                factor = {"mass": "alpha", "stiffness": "beta"}[role]
                yield Term("damping", matrix, coefficient.times(f"{path}.damping.{factor}"))

    def weighted(self, factor: Callable[[Floats], Floats]) -> Iterator[Term]:
        """Yield K and M whose integrands are multiplied by a factor, (dim, n) to (n,)."""
        space, reduced, rho = self.body.space, self.body.reduced, self.body.density
        law = replace(self.body.material.elasticity, factor=factor)
        parts: list[tuple[Role, Mat, Coefficient]] = [
            ("stiffness", reduced(space.stiffness(law)), self._stiffness),
            ("mass", reduced(space.mass(lambda x: rho * factor(x))), self._mass),
        ]
        for role, own, coefficient in parts:
            whole = self.placed(own)
            if whole is not own:
                destroy(own)
            yield Term(role, whole, coefficient)

    def _of_constants(self) -> Iterator[Term]:
        """Yield the change of K with the constants of a solid that has several."""
        material, path = self.body.material, self.path
        beta, damping = f"{path}.damping.beta", self.motion.damping

        def grown(place: tuple[int, int], factor: str, values: Mapping[str, Any]) -> Any:
            own = {name: values[f"{path}.material.{name}"] for name in material.constants}
            entry = (material.matrix_of(own) - material.elasticity.matrix)[place]
            return entry * values[factor] if factor else entry

        for place, own in material.entries.items():
            unit = np.zeros((6, 6))
            unit[place] = unit[place[::-1]] = 1.0
            make = cache(partial(self._stiffness_of, Elasticity(unit, material.axes)))
            names = frozenset(f"{path}.material.{name}" for name in own)
            yield TermOfConstant("stiffness", make, Smooth(names, partial(grown, place, "")))
            if self.with_mass and damping is not None:
                damped = Smooth(names | {beta}, partial(grown, place, beta))
                yield TermOfConstant("damping", make, damped)

    def _stiffness_of(self, law: Elasticity) -> Mat:
        """Return K of another elastic law."""
        return self.placed(self.body.reduced(self.body.space.stiffness(law)))

    def _of_rotation(self, rotation: Rotation) -> Iterator[Term]:
        """Yield Omega Y and - Omega^2 Z."""
        rate = f"{self.path}.rotation.rate"
        if self.with_mass:
            Y = self.placed(self.body.gyroscopic(rotation))
            yield Term("damping", Y, self._mass.times(rate), symmetric=False)
        if rotation.convective_stiffness:
            Z = self.placed(self.body.convective_stiffness(rotation))
            yield Term("stiffness", Z, self._mass.times(rate, 2.0, factor=-1.0))

    def _carried(self) -> Iterator[Term | UnformedTerm[Circulatory]]:
        """Yield the circulatory terms of damping that rotates: one sparse, the others unformed."""
        rotation, damping = self.motion.rotation, self.motion.damping
        assert rotation is not None
        rate = f"{self.path}.rotation.rate"
        B = self.body.gyroscopic(rotation.of_material)
        B.scale(0.5)
        if self.motion.modal is not None and len((modes := self._damped_modes).weights):
            layout, comm = (PETSc.DECIDE, len(modes.weights)), self.body.expansion.comm
            left, turned = (
                self.placed(distributed(csr_array(columns), layout, comm), columns=False)
                for columns in (modes.images * modes.weights, -times(B, modes.vectors))
            )
            one = identity(left.getLocalSize()[1], left.comm)
            piece = Circulatory(left, one, turned.transpose(PETSc.Mat()))
            destroy(turned)
            yield UnformedTerm(piece, self._modal_ratio.times(rate))
        if damping is None:
            return
        alpha = self._mass.times(f"{self.path}.damping.alpha").times(rate)
        yield Term("stiffness", self.placed(B), alpha, symmetric=False)
        left = self.placed(self.body.elastic_stiffness(), columns=False)
        right = self.placed(B, rows=False)
        beta = self._stiffness.times(f"{self.path}.damping.beta").times(rate)
        yield UnformedTerm(Circulatory(left, self.body.mass(), right), beta)

    @cached_property
    def _damped_modes(self) -> "DampedModes":
        """Modes with modal damping."""
        assert self.motion.modal is not None
        from cea.system.modal_damping import damped_modes

        return damped_modes(self.path, self.body, self.motion.modal)


class TermOfConstant(Term):
    """Symmetric term whose matrix is computed when a material constant first changes."""

    def __init__(self, role: Role, make: Callable[[], Mat], coefficient: Dependence) -> None:
        vars(self).update(role=role, make=make, coefficient=coefficient)

    @cached_property
    def matrix(self) -> Mat:
        """The matrix, PETSc AIJ (n x n)."""
        return vars(self)["make"]()


@dataclass(frozen=True, eq=False)
class Smooth:
    """An analytic function of parameters: a :class:`Dependence`."""

    names: frozenset[str]  # parameters it depends on
    function: Callable[[Mapping[str, Any]], Any]  # of all parameters by name

    def at(self, values: Mapping[str, float]) -> float:
        """Return the value at given parameters."""
        return float(self.function(values))

    def derivative(self, name: str, values: Mapping[str, float]) -> float:
        """Return the derivative in one parameter by a complex step, exact to rounding."""
        step = 1e-20 * (abs(values[name]) or 1.0)
        return float(self.function({**values, name: values[name] + 1j * step}).imag / step)
