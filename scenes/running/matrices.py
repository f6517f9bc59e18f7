"""Runs of scenes of matrices: a single run, or many at different parameters."""

from collections.abc import Callable, Mapping
from typing import Any

from cea.eigen.driver import EigenSolver
from cea.errors import require
from cea.reduced.full_solves import ConfirmedThreshold, first_threshold
from cea.timing import StageTimer
from scenes.checking.skipped import GIVEN
from scenes.matrices.reading import Piece, check_mass, matrix_pencil, read_pieces
from scenes.results.result import Result
from scenes.spec.matrices import ROLES, MatrixScene


class AssembledMatrices:
    """A scene of matrices that is read once and solved many times at different parameters.

    Attributes are the matrices by name, ``pieces``, and the eigensolver ``driver`` of the pencil;
    ``listener`` is called with the name of each stage as it begins. Raises an InputError for a file
    without the matrix, different sizes, and a mass matrix that is not symmetric.
    """

    def __init__(self, scene: MatrixScene, listener: Callable[[str], None] | None = None) -> None:
        self.scene = scene
        self.timer = StageTimer(listener)
        with self.timer("reading"):
            self.pieces = read_pieces(scene)
        self.driver = EigenSolver(matrix_pencil(scene, self.pieces))
        self._checked: tuple[float, ...] | None = None

    def modes(
        self,
        changes: Mapping[str, Any] | None = None,
        *,
        left: bool = False,
        listener: Callable[[str], None] | None = None,
    ) -> Result:
        """Compute the modes of the scene with parameters and the window changed.

        Parameters and errors are those of :meth:`scenes.AssembledScene.modes`. Changes of files or
        sums and a mass that is not positive definite raise an InputError.
        """
        scene = self.scene.change(dict(changes or {}))
        for name in ("files", "symmetric", "data", *ROLES):
            own, new = getattr(self.scene, name), getattr(scene, name)
            require(new == own, name, new, "unchanged: assemble another scene for other matrices")
        timer, window = StageTimer(listener), scene.window
        self._check_mass(scene.values, timer)
        top, low = window.max_frequency, window.min_growth
        options: Any = {"min_growth": low, "left": left, "timer": timer}
        modes = self.driver.solve(top, scene.values, hints=True, **options)
        known = scene, timer, skipped_by(scene, self.pieces)
        return Result(*known, modes.warnings, spectrum=modes, pieces=self.pieces)

    def threshold(
        self, parameter: str, real: float, flutter: float, *, frequency: float | None = None
    ) -> ConfirmedThreshold:
        """Return the first value of a parameter at which a mode begins to grow.

        Parameters and errors are those of :meth:`scenes.AssembledScene.threshold`, with a parameter
        such as ``parameters.Omega``.
        """
        for value in (real, flutter):
            self._check_mass(self.scene.change({parameter: value}).values, StageTimer())
        name, top = self.driver.pencil.parameter(parameter).name, self.scene.window.max_frequency
        return first_threshold(
            self.driver, name, real, flutter, max_frequency=top, frequency=frequency
        )

    def _check_mass(self, values: Mapping[str, float], timer: StageTimer) -> None:
        """Raise an InputError if the mass is not positive definite; skip unchanged coefficients."""
        mass = self.scene.sum("mass")
        coefficients = tuple(coefficient.at(values) for coefficient in mass.values())
        if coefficients != self._checked:
            with timer("factorisation"):
                check_mass(self.driver.matrices(values).mass, " + ".join(mass))
            self._checked = coefficients

    def free(self) -> None:
        """Free the factors that are kept between solves."""
        self.driver.free()


def run_matrices(
    scene: MatrixScene, *, left: bool = False, listener: Callable[[str], None] | None = None
) -> Result:
    """Compute the modes of a scene of matrices; see :meth:`AssembledMatrices.modes`."""
    assembled = AssembledMatrices(scene, listener)
    result = assembled.modes(left=left, listener=listener)
    for stage, seconds in assembled.timer.seconds.items():
        result.timer.add(stage, seconds)
    assembled.free()
    return result


def skipped_by(scene: MatrixScene, pieces: Mapping[str, Piece]) -> dict[str, str]:
    """Return the stages that the scene does not need and its unused inputs, with reasons."""
    values, sums = scene.values, {role: scene.sum(role) for role in ROLES}
    acting = {role: [n for n, c in sums[role].items() if c.at(values) != 0] for role in ROLES}
    without = ("meshing", "search", "contact", "pictures", "paraview")
    skipped = dict.fromkeys(without, "matrices come from files")
    for role in ("damping", "stiffness"):
        zero = [name for name in sums[role] if name not in acting[role]]
        skipped |= {f"{role}.{name}": "its coefficient is zero" for name in zero}
    used = {name for formulas in sums.values() for c in formulas.values() for name in c.names}
    unused = {path: "in no coefficient" for path in values if path not in used}
    if not acting["damping"]:
        skipped["damping"] = "no damping matrix: the problem is linear in lambda^2"
        parts = [part for name in acting["stiffness"] for part in pieces[name].parts]
        if all(symmetric for _, symmetric in parts):
            skipped["unsymmetric solver"] = "every matrix of the stiffness is symmetric"
        if scene.window.min_growth is not None:
            unused["analysis.min_growth"] = "without damping, the growth rate has no limit"
    return skipped | {field: f"{GIVEN}{reason}" for field, reason in unused.items()}
