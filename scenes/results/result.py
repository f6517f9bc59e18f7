"""Result of a scene, from a run or read back from a record."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from cea.arrays import Complexes, Floats, Ints
from cea.body import Body
from cea.contact.interface import Interface
from cea.eigen.classify import RunWord
from cea.eigen.modes import Modes
from cea.eigen.spectrum import Spectrum
from cea.errors import InputError, ResultWarning
from cea.files import write_whole
from cea.surface_points import SurfaceCoordinates
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.results.data import described, steady_lines
from scenes.results.shapes import displacements, given_matrices, system_matrices
from scenes.spec.body import backend_name

if TYPE_CHECKING:
    from PIL.Image import Image

    from cea.system.contact_stresses import NormalStress
    from cea.system.steady_state import SteadySliding


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Result of a run of a scene.

    Modes are numbered from 1 in tables, files and pictures, and indexed from 0 in arrays. A result
    that was read back has no matrices and vectors; methods that need them raise an InputError.

    Parameters
    ----------
    scene
        The scene as run: :class:`scenes.Scene` or :class:`scenes.MatrixScene`.
    timer
        Times (s) by stage.
    skipped
        Stages that the scene did not need and unused inputs, with the reasons.
    warnings
        Warnings about the result.
    spectrum
        Eigenvalues with their errors and the window; None for a static analysis.
    stresses
        Normal stresses of a static analysis by contact, then side "a" or "b".
    reactions
        Forces (N) of each support on its body in equilibrium with the loads, by body, shape
        (supports, dim), in the order of the scene; empty if no equilibrium is computed.
    pieces
        Matrices of a scene of matrices as read, by name.
    coupled
        The coupled system of bodies and contacts.
    solution
        Unknowns of a static analysis, PETSc vector.
    record
        The record that the result was read from; empty for a run.
    """

    scene: Any
    timer: StageTimer
    skipped: Mapping[str, str]
    warnings: tuple[ResultWarning, ...] = ()
    spectrum: Spectrum | None = None
    stresses: Mapping[str, Mapping[str, "NormalStress"]] = field(default_factory=dict)
    reactions: Mapping[str, Floats] = field(default_factory=dict)
    pieces: Mapping[str, Any] = field(default_factory=dict)
    coupled: CoupledSystem | None = None
    solution: Any = None
    record: Mapping[str, Any] = field(default_factory=dict)

    @property
    def data(self) -> Mapping[str, Any]:
        """Data of the record of the result (`docs/result_json.md`); collective."""
        return self.record or described(self)

    @property
    def system(self) -> CoupledSystem:
        """Coupled system of bodies and contacts; raises an InputError if there is none."""
        return _there(self.coupled, "system", "a fresh run of bodies")

    @property
    def displacement(self) -> Any:
        """Unknowns of a static analysis, PETSc vector; raises an InputError if there are none."""
        return _there(self.solution, "displacement", "a fresh run of a static analysis")

    @property
    def modes(self) -> Modes:
        """Eigenvalues with their errors; without vectors if the result was read back."""
        return cast(Modes, _there(self.spectrum, "modes", "an analysis that computes modes"))

    @property
    def analysis(self) -> Any:
        """The analysis of the scene."""
        return self.scene.analysis

    @property
    def dofs(self) -> int:
        """Number of free dofs."""
        if self.record:
            return int(self.record["dofs"]["free"])
        return int(self.modes.template.getSize() if self.coupled is None else self.coupled.size)

    @property
    def comm(self) -> Any:
        """Communicator (mpi4py)."""
        template = self.modes.template if self.coupled is None else self.coupled.template
        return template.comm.tompi4py()

    @property
    def bodies(self) -> Mapping[str, Body]:
        """Bodies by name; raises an InputError if the result was read back."""
        return self.system.bodies

    @property
    def interfaces(self) -> dict[str, Interface]:
        """Contact points by half pass; raises an InputError if the result was read back."""
        return {contact.name: contact.interface for contact in self.system.contacts}

    @property
    def steady(self) -> "SteadySliding | None":
        """State of steady sliding; None if the stiffness of every contact is given."""
        return self.system.steady

    @property
    def eigenvalues(self) -> Complexes:
        """Eigenvalues lambda (1/s) in order of increasing frequency, shape (n,)."""
        return self.modes.eigenvalues

    @property
    def frequencies(self) -> Floats:
        """Frequencies (Hz), shape (n,)."""
        return self.modes.frequencies

    @property
    def growth_rates(self) -> Floats:
        """Growth rates (1/s), shape (n,)."""
        return self.modes.growth_rates

    @property
    def damping_ratios(self) -> Floats:
        """-Re lambda / abs(lambda), shape (n,): negative for growing modes, NaN for rigid ones."""
        return self.modes.damping_ratios

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """Mask of the modes that are unstable by the scene's growth threshold, shape (n,)."""
        return self.modes.unstable(self.analysis.growth_threshold)

    @property
    def verdict(self) -> RunWord:
        """Classification of the whole window by :func:`cea.eigen.classify.classify_run`."""
        return self.modes.verdict(self.analysis.growth_threshold)

    @property
    def summary(self) -> str:
        """One line with the number of modes of each class, the threshold and the verdict."""
        return f"{self.scene.name}: {self.modes.headline(self.analysis.growth_threshold)}"

    def most_unstable(self, count: int) -> list[int]:
        """Return indices, from 0, of the most unstable modes; the first ones if all are stable."""
        unstable = np.flatnonzero(self.unstable)
        if not len(unstable):
            return list(range(min(count, len(self.modes))))
        order = np.argsort(-self.growth_rates[unstable], kind="stable")
        return unstable[order][:count].tolist()

    def title(self, index: int) -> str:
        """Return the title of a mode: backend, number from 1, frequency and growth rate."""
        begin = f"{backend_name(self.scene.backends)}, mode {index + 1}: "
        if self.modes.rigid[index]:
            return f"{begin}rigid motion"
        return (
            f"{begin}{self.frequencies[index]:.2f} Hz, "
            f"growth rate {self.growth_rates[index]:+.2f} 1/s"
        )

    def matrices(self) -> dict[str, csr_array]:
        """Return the matrices by name, at the parameters of the solution; collective.

        Rows are the free dofs of all ranks. There are K and M of the bodies, and K_n and K_f of the
        contacts. K_f is zero without friction; M is omitted in static analyses; C exists with
        damping and Y with rotation. K includes convective and geometric stiffness. With modal
        damping the damping matrix is C + W W^T, which would be dense. Damping of a rotating body
        adds the stiffness K_c, or K_c + L N^-1 J (:mod:`cea.motion`); K_c also has the skew part of
        the stiffness of pressures that turn with their surfaces. A scene of matrices has M, C if
        there is damping, and K.

        The matrices are scipy's (N/m, kg, N s/m) on rank 0; other ranks get an empty dict. Raises
        an InputError for tied contacts, where K_n is infinite, and for results read back.
        """
        if self.pieces:
            return given_matrices(self.modes.pencil, self.modes.values, self.modes.template)
        system = self.system
        values = system.pencil().values() if self.spectrum is None else self.modes.values
        return system_matrices(system, values)

    def mode_shapes(
        self,
        place: str,
        at: SurfaceCoordinates | csr_array | None = None,
        modes: Sequence[int] | Ints | None = None,
        *,
        everywhere: bool = True,
    ) -> Complexes:
        """Return complex displacements of modes at points; collective.

        Parameters
        ----------
        place
            A body, or a surface "body.surface".
        at
            On a surface, coordinates of the points, as returned by ``locate``. On a body, values of
            its scalar basis functions at the points, shape (n, num_scalar_dofs); None returns the
            values of the scalar dofs.
        everywhere
            Whether every rank passes the points and gets the result; otherwise rank 0 does, and
            others get an empty array.
        modes
            Indices of the modes, from 0, as in :attr:`eigenvalues`; by default all.

        Returns
        -------
        ndarray
            Shape (n, dim, modes).
        """
        system = self.system  # raises if the result was read back
        vectors = self.modes.vectors if modes is None else self.modes.vectors[:, list(modes)]
        return displacements(system, place, at, vectors, everywhere=everywhere)

    def displacements(
        self,
        place: str,
        at: SurfaceCoordinates | csr_array | None = None,
        *,
        everywhere: bool = True,
    ) -> Floats:
        """Return static displacements (m), (n, dim); see :meth:`mode_shapes`; collective."""
        vectors = self.displacement.array[:, None].astype(complex)
        u = displacements(self.system, place, at, vectors, prescribed=1.0, everywhere=everywhere)
        return u[..., 0].real

    def plot(self, mode: int | None = None) -> "Image | None":
        """Draw a mode at the phase of its largest deflection, by default the most unstable one.

        Modes are numbered from 1 as in :meth:`table`; other numbers raise an InputError. Returns a
        PIL image on rank 0, and None on other ranks.
        """
        count = len(self.modes)
        if mode is None and count:
            mode = self.most_unstable(1)[0] + 1
        if mode is None or not 1 <= mode <= count:
            raise InputError("mode", mode, f"the number of a mode, from 1 to {count}")
        return next(self.images([int(mode) - 1]), None)

    def images(self, modes: Sequence[int]) -> Iterator["Image"]:
        """Yield images of modes by index on rank 0; nothing on others; collective at the start."""
        from scenes.results.pictures import SUBDIVISIONS, draw_mode, outside  # imports pyvista

        cells = {name: body.space.volume_cells() for name, body in self.bodies.items()}
        shapes = {
            name: self.mode_shapes(name, each.values, modes, everywhere=False)
            for name, each in cells.items()
        }
        for i, mode in enumerate(modes if self.comm.rank == 0 else ()):
            surfaces = []
            for name, each in cells.items():
                u = shapes[name][..., i]
                surfaces.append(outside(each, {"real": u.real, "imaginary": u.imag}, SUBDIVISIONS))
            yield draw_mode(surfaces, self.title(mode))

    def draw(self, count: int, out: Path) -> list[Path]:
        """Draw ``count`` modes, those of :meth:`most_unstable`; collective.

        Rank 0 writes the files ``mode_<backend>_<number of the mode>.png``.
        """
        from scenes.results.pictures import png  # imports pyvista

        modes = self.most_unstable(count)
        files = [out / f"mode_{self.scene.backends}_{mode + 1}.png" for mode in modes]
        for file, image in zip(files, self.images(modes), strict=False):
            write_whole(png(image), file)
        return files

    def steady_lines(self) -> list[str]:
        """Return lines about contact forces in steady sliding, and reactions of moved supports."""
        data = self.data
        lines = steady_lines(data["steady_sliding"]) if "steady_sliding" in data else []
        if self.scene.backends == "matrices" or not self.scene.prescribes:
            return lines
        return lines + [
            f"{name}, {self.scene.bodies[name].supports[number].surface}: support force "
            f"{', '.join(f'{part:.6g}' for part in force)} N"
            for name, forces in data.get("reactions", {}).items()
            for number, force in enumerate(forces)
        ]

    def table(self) -> Any:
        """Return the rows of the result: a :class:`cea.mode_table.ModeTable` of the modes.

        A static analysis has a row for each side of each contact, with extremes and oscillation of
        the normal stress (N/m^2).
        """
        if self.spectrum is not None:
            return self.spectrum.table(self.analysis.growth_threshold)
        numbers = ("min", "max", "oscillation")
        return [
            {"contact": name, "side": side} | {each: getattr(stress, each) for each in numbers}
            for name, sides in self.stresses.items()
            for side, stress in sides.items()
        ]

    def __repr__(self) -> str:
        if self.spectrum is not None:
            text = self.modes.text(self.analysis.growth_threshold)
            lines = [f"{self.scene.name}: {text}", f"{self.dofs} dofs"]
            lines += [f"window: {self.modes.window.evidence}", *self.steady_lines()]
            lines += [f"warning ({warning.kind}): {warning.message}" for warning in self.warnings]
            return "\n".join(lines)
        lines = [f"{self.scene.name}: static analysis", *self.steady_lines()]
        for row in self.table():
            low, high, oscillation = (f"{row[n]:.6g}" for n in ("min", "max", "oscillation"))
            of = f"{row['contact']}, side {row['side']}: sigma_n from {low} to {high}"
            lines.append(f"{of}, oscillation {oscillation} N/m^2")
        return "\n".join(lines)


def _there[T](value: T | None, name: str, allowed: str) -> T:
    if value is None:
        raise InputError(name, None, allowed)
    return value
