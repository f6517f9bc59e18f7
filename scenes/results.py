"""What running a scene gives, a class for each kind of analysis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any

from scipy.sparse import csr_array

from cea.arrays import Complexes, Floats, Ints
from cea.body import Body
from cea.contact.interface import Interface
from cea.eigen.modes import Modes
from cea.eigen.multipliers import with_circulatory
from cea.errors import InputError
from cea.matrices import destroy, local_part
from cea.petsc import PETSc
from cea.surface_points import SurfaceCoordinates
from cea.system.contact_stresses import SideStress
from cea.system.coupled import CoupledSystem
from cea.system.sliding_state import SteadySliding
from cea.timing import StageTimer
from cea.warned import ResultWarning
from scenes.arrays import gathered_displacements, gathered_rows, gathered_sums
from scenes.of_modes import OfModes
from scenes.of_stresses import Extremes, stress_lines, stress_rows
from scenes.read import Scene
from scenes.spec.analysis import StaticAnalysis
from scenes.steady import steady_data, steady_lines

if TYPE_CHECKING:
    from PIL.Image import Image

    from scenes.drawing import Drawing


@dataclass(frozen=True)
class SceneResult:
    """What every run gives.

    Parameters
    ----------
    scene
        The scene as run.
    system
        Its coupled matrices.
    interfaces
        Contact points by name of the half pass.
    timer
        Seconds by stage.
    skipped
        What the scene did not need, with the reason.
    reactions
        Forces (N) of each support on its body in equilibrium with the loads, by body, shape
        (supports, dim), in the order of the scene; empty where no equilibrium is sought.
    """

    scene: Scene
    system: CoupledSystem
    interfaces: Mapping[str, Interface]
    timer: StageTimer
    skipped: Mapping[str, str]
    reactions: Mapping[str, Floats] = field(default_factory=dict, kw_only=True)

    @property
    def dofs(self) -> int:
        """Free dofs."""
        return int(self.system.size)

    @property
    def bodies(self) -> Mapping[str, Body]:
        """Bodies by name."""
        return self.system.bodies

    @property
    def steady(self) -> SteadySliding | None:
        """The state of steady sliding; None where the stiffness of every contact is given."""
        return self.system.steady

    def steady_lines(self) -> list[str]:
        """What contacts carry in steady sliding; where supports prescribe, what they bear too."""
        contacts = [] if self.steady is None else steady_lines(steady_data(self.steady))
        if not self.scene.prescribes:
            return contacts
        return contacts + [
            f"{name}, {self.scene.bodies[name].supports[number].surface}: support bears "
            f"{', '.join(f'{part:.6g}' for part in force)} N"
            for name, forces in self.reactions.items()
            for number, force in enumerate(forces)
        ]

    def matrices(self) -> dict[str, csr_array]:
        """Matrices by name: K and M of the bodies, K_n and K_f of the contacts.

        Their rows are the free dofs of all ranks. K_f is zero without friction, M is left out of
        static analyses. C is there where something damps, Y where a body rotates; convective and
        geometric stiffness are part of K. Modal damping would be full: W is there where modes of a
        body are damped, a column for each, and the damping is C + W W^T. Damping that rotates with
        its body makes K_c of displacements, and what would be full: with J, N and L, which are
        there, K_c + L N^-1 J (:mod:`cea.rotation`).

        Returns
        -------
        dict
            scipy matrices (N/m, kg, N s/m) on rank 0; empty on other ranks.

        Raises
        ------
        InputError
            Where the sides of a contact are tied: K_n is infinite.
        """
        values = self._values()
        for contact in self.system.contacts:
            name = f"contacts.{contact.pair}.P"
            if not values.get(name, 0.0) < inf:
                raise InputError(name, values[name], "finite for matrices")
        pencil = self.system.pencil(eliminate=True)
        pieces: dict[str, list[tuple[float, Any]]] = {"K": [], "M": [], "K_n": [], "K_f": []}
        for term in pencil.terms:
            factor = term.coefficient.at(values)
            if term.role == "mass":
                pieces["M"].append((factor, term.matrix))
            elif term.role == "damping":
                name = "C" if term.symmetric else "Y"
                pieces.setdefault(name, []).append((factor, term.matrix))
            elif term.contact:
                name, sign = ("K_n", 1) if term.symmetric else ("K_f", -1)
                pieces[name].append((sign * factor, term.matrix))
            else:
                name = "K" if term.symmetric else "K_c"
                pieces.setdefault(name, []).append((factor, term.matrix))
        if not pieces["M"]:
            del pieces["M"]
        sums = gathered_sums(pieces, self.system.template)
        low_rank = pencil.low_rank_at(values)
        if low_rank is not None:
            sums |= gathered_rows("W", csr_array(low_rank.root()), self.comm)
        circulatory = pencil.circulatory_at(values)
        if circulatory is not None:
            full = with_circulatory(None, circulatory)
            left = full.reaction.transpose(PETSc.Mat())
            for name, matrix in (("L", left), ("N", full.compliance), ("J", full.closure)):
                sums |= gathered_rows(name, local_part(matrix), self.comm)
            full.free()
            destroy(left)
        return sums

    def _values(self) -> Mapping[str, float]:
        """The parameters that were solved at."""
        return self.system.pencil().values()

    @property
    def comm(self) -> Any:
        """Communicator (mpi4py)."""
        return next(iter(self.bodies.values())).comm

    def _displacements(
        self,
        place: str,
        at: SurfaceCoordinates | csr_array | None,
        vectors: Complexes,
        *,
        everywhere: bool,
        prescribed: float = 0.0,
    ) -> Complexes:
        body, _, name = place.partition(".")
        if body not in self.bodies:
            raise InputError("place", place, f"one of {', '.join(self.bodies)}")
        if name:
            surfaces = self.bodies[body].surfaces
            if name not in surfaces or not isinstance(at, SurfaceCoordinates):
                allowed = ", ".join(f"{body}.{each}" for each in surfaces)
                raise InputError("place", place, f"one of {allowed}, with coordinates on it")
            at = surfaces[name].trace(at)
        elif isinstance(at, SurfaceCoordinates):
            raise InputError("place", place, "a surface, body.surface, for coordinates on it")
        options: Any = {"prescribed": prescribed, "everywhere": everywhere}
        return gathered_displacements(self.system, body, at, vectors, **options)


@dataclass(frozen=True)
class ModesResult(SceneResult, OfModes):
    """Modes of a complex eigenvalue analysis.

    Parameters
    ----------
    modes
        Eigenvalues, eigenvectors, their errors and the window that was searched.
    """

    scene: Scene
    modes: Modes

    __repr__ = OfModes.__repr__

    @property
    def warnings(self) -> tuple[ResultWarning, ...]:
        """What the result must be read with: the warnings of its modes are all of them."""
        return self.modes.warnings

    def _values(self) -> Mapping[str, float]:
        return self.modes.values

    def relative_stiffness(self, contact: str) -> float:
        """P of a contact where the modes were solved for, over that of the system's matrices.

        1 where steady sliding makes it, and nothing changes it.
        """
        name = f"contacts.{contact}.P"
        if name not in self.modes.values:
            return 1.0
        return self.modes.values[name] / self.modes.pencil.parameters[name].value

    def mode_shapes(
        self,
        place: str,
        at: SurfaceCoordinates | csr_array | None = None,
        modes: Sequence[int] | Ints | None = None,
        *,
        everywhere: bool = True,
    ) -> Complexes:
        """Complex displacements of modes at points; collective.

        Parameters
        ----------
        place
            A body; or a surface, "body.surface".
        at
            On a surface, coordinates of the points, as locating gives them. On a body, the values
            of its scalar basis functions at the points, shape (n, num_scalar_dofs); None takes
            the scalar dofs themselves.
        modes
            Indices of the modes, from 0, as in :attr:`eigenvalues`; None takes all.
        everywhere
            Whether every rank gives the points and gets the answer; otherwise rank 0 does, and
            others get an empty array.

        Returns
        -------
        ndarray
            Shape (n, dim, modes).
        """
        chosen = self.modes.vectors if modes is None else self.modes.vectors[:, list(modes)]
        return self._displacements(place, at, chosen, everywhere=everywhere)

    def plot(self, mode: int | None = None) -> "Image | None":
        """Draw a mode at the phase of its largest deflection.

        Parameters
        ----------
        mode
            Its number, from 1, as :meth:`table` has it; by default the most unstable one.

        Returns
        -------
        PIL.Image.Image
            On rank 0, None on other ranks. A notebook shows it; ``save`` writes it.

        Raises
        ------
        InputError
            When there is no such mode.
        """
        drawings = self.drawings([self.index(mode)])
        return drawings[0].images([0.0])[0] if drawings else None

    def drawings(self, modes: Sequence[int]) -> list["Drawing"]:
        """Modes, by their indices, ready to be drawn at any phase; none but on rank 0."""
        from scenes.drawing import Drawing  # brings pyvista

        samples = {name: body.volume_sample(2) for name, body in self.bodies.items()}
        shapes = {
            name: self.mode_shapes(name, sample.values, modes, everywhere=False)
            for name, sample in samples.items()
        }
        if self.system.template.comm.rank:
            return []
        return [
            Drawing.of(samples, {n: u[..., i] for n, u in shapes.items()}, self.title(mode))
            for i, mode in enumerate(modes)
        ]


@dataclass(frozen=True)
class StaticResult(SceneResult):
    """Displacement and contact stresses of a static analysis.

    Parameters
    ----------
    displacement
        Unknowns, PETSc vector.
    stresses
        Normal stresses by contact, then side "a" or "b".
    warnings
        What the result must be read with.
    """

    displacement: Any
    stresses: Mapping[str, Mapping[str, SideStress]]
    warnings: tuple[ResultWarning, ...] = ()

    @property
    def analysis(self) -> StaticAnalysis:
        """The analysis of the scene."""
        assert isinstance(self.scene.analysis, StaticAnalysis)
        return self.scene.analysis

    def displacements(
        self,
        place: str,
        at: SurfaceCoordinates | csr_array | None = None,
        *,
        everywhere: bool = True,
    ) -> Floats:
        """Displacements (m) at points, shape (n, dim), as in :meth:`ModesResult.mode_shapes`."""
        vectors = self.displacement.array[:, None].astype(complex)
        options: Any = {"everywhere": everywhere, "prescribed": 1.0}
        return self._displacements(place, at, vectors, **options)[..., 0].real

    def table(self) -> list[dict[str, Any]]:
        """A row for each side of each contact: extremes and oscillation of sigma_n (N/m^2)."""
        return stress_rows(
            {
                name: {
                    side: Extremes(float(s.sigma_n.min()), float(s.sigma_n.max()), s.oscillation)
                    for side, s in sides.items()
                }
                for name, sides in self.stresses.items()
            }
        )

    def __repr__(self) -> str:
        rows = stress_lines(self.table())
        return "\n".join([f"{self.scene.name}: static analysis", *self.steady_lines(), *rows])
