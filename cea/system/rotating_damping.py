"""Damping that rotates with its body: what it makes of displacements at rest in space.

With B = int rho v . R u of the rotation (:mod:`cea.rotation`), pieces of the stiffness are

    alpha Omega B,    beta Omega K M^-1 B,    Omega sum_j 2 zeta_j omega_j (M phi_j) (B^T phi_j)^T,

the last two full (:mod:`cea.eigen.unformed`). K is without the springs of the body, which stay
where they are in space.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from cea.body import Body
from cea.eigen.blocks import image_of
from cea.eigen.pencil import Term
from cea.eigen.unformed import Circulatory, CirculatoryTerm
from cea.matrices import destroy, identity, scaled_total
from cea.petsc import Mat, PETSc
from cea.rotation import Rotation
from cea.system.body_terms import Motion, of_mass, of_stiffness
from cea.system.embedding import Embedding
from cea.system.modal_damping import DampedModes, modal_coefficient


@dataclass(frozen=True)
class RotatingDamping:
    """Damping of one body, carried along by its rotation.

    Parameters
    ----------
    path
        Path of the body in a scene.
    body
        The body.
    motion
        Its damping and its rotation.
    modes
        Its modes that are damped one by one; None without modal damping.
    among
        Its unknowns among those of all bodies.
    """

    path: str
    body: Body
    motion: Motion
    modes: DampedModes | None
    among: Embedding

    @cached_property
    def pieces(self) -> tuple[list[Term], list[CirculatoryTerm]]:
        """Pieces of the stiffness, sparse ones and full ones."""
        assert self.motion.rotation is not None
        B = transport(self.body, self.motion.rotation)
        terms, full = list[Term](), list(self._modal(B))
        if self.motion.damping is not None:
            alpha = of_mass(self.path, self.body).times(f"{self.path}.damping.alpha")
            terms.append(
                Term("stiffness", self.among.square(B), alpha.times(self._rate), symmetric=False)
            )
            full.append(self._of_stiffness(B))
        return terms, full

    def strain(self, x: Any) -> Any | None:
        """Displacement that elastic forces of beta K belong to: beta Omega M^-1 B of one in space.

        Parameters
        ----------
        x
            Displacements of all unknowns (m), PETSc vector.

        Returns
        -------
        PETSc.Vec
            Displacement of all dofs of the body (m); None without damping of its stiffness.
        """
        damping, rotation = self.motion.damping, self.motion.rotation
        if damping is None or rotation is None or not damping.beta * rotation.rate:
            return None
        piece = self.pieces[1][-1].piece
        free, full = self.body.expansion.createVecs()
        free.array[:] = damping.beta * rotation.rate * piece.inner(x.array_r[:, None])[:, 0]
        self.body.expansion.mult(free, full)
        destroy(free)
        return full

    @property
    def _rate(self) -> str:
        return f"{self.path}.rotation.rate"

    def _of_stiffness(self, B: Mat) -> CirculatoryTerm:
        """The piece beta Omega K M^-1 B."""
        K, springs = self.body.stiffness(), self.body.spring_stiffness()
        if springs is not None:
            K = scaled_total([(1.0, K), (-1.0, springs)])
        piece = Circulatory(self.among.columns(K), self.body.mass(), self.among.rows(B))
        beta = of_stiffness(self.path, self.body).times(f"{self.path}.damping.beta")
        return CirculatoryTerm(piece, beta.times(self._rate))

    def _modal(self, B: Mat) -> Iterator[CirculatoryTerm]:
        """The piece Omega sum_j 2 zeta_j omega_j (M phi_j) (B^T phi_j)^T."""
        modes, damping = self.modes, self.motion.modal
        if modes is None or damping is None or not len(modes.weights):
            return
        left = self.among.upright(modes.images * modes.weights)
        turned = self.among.upright(-image_of(B, modes.vectors))
        right = turned.transpose(PETSc.Mat())
        destroy(turned)
        piece = Circulatory(left, identity(left.getLocalSize()[1], left.comm), right)
        coefficient = modal_coefficient(self.path, self.body, damping, self._rate)
        yield CirculatoryTerm(piece, coefficient)


def transport(body: Body, rotation: Rotation) -> Mat:
    """B of a rotation (:mod:`cea.rotation`), PETSc AIJ (free x free), kg, skew; a new matrix."""
    matrix = body.gyroscopic(rotation.of_material)
    matrix.scale(0.5)
    return matrix
