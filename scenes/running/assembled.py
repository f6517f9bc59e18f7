"""A scene assembled once and solved many times: sweeps over friction, stiffness, materials."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.errors import InputError, ResultWarning, require
from cea.reduced.full_solves import ConfirmedThreshold, first_threshold
from cea.timing import StageTimer
from scenes.results.result import Result
from scenes.running.run import coupled, result_of_modes, run_modes, solved, system_warnings
from scenes.running.swept import at_parameters, in_saddle_form, parameters_changed, parameters_meant
from scenes.spec.reading import Scene

_SAMPLES = 5
"""Number of values at which unstable modes are sought to bracket a threshold before bisection."""
_RESOLVED = 1e-8
"""Relative width of the bracket at which bisection ends."""


class AssembledScene:
    """A scene whose matrices are the pieces of a parametric pencil.

    Modes of the scene with fields changed equal those of a fresh run. Changes of E, rho, damping or
    rate of rotation of a body, and of P, mu, pressure, speed or slope of friction of a contact need
    no assembly, unless they change the state of steady sliding or the form of a contact. Other
    changes rebuild the affected bodies, the contacts and the state of steady sliding.

    Parameters
    ----------
    scene
        A scene with a complex eigenvalue analysis; others raise an InputError.
    listener
        Called with the name of each stage as it begins.

    Attributes
    ----------
    bodies
        Bodies by name.
    driver
        Eigensolver of the pencil.
    timer
        Times of assembly (s) by stage.
    """

    def __init__(self, scene: Scene, listener: Callable[[str], None] | None = None) -> None:
        self.scene = scene
        _ = scene.window  # raises for a static analysis
        # Friction terms are kept at mu = 0, where a sweep may begin.
        self._system, self.timer = coupled(scene, leave_out=False, listener=listener)
        self.bodies = self._system.bodies
        with self.timer("assembly"):
            self.driver = EigenSolver(self._system.pencil())

    @property
    def bonded(self) -> list[str]:
        """Names of the bonded contacts, which cannot slide."""
        contacts = self.scene.contacts.items()
        return [name for name, each in contacts if each.formulation.coupling == "bonded"]

    def depends_on_state(self, names: Sequence[str]) -> bool:
        """Whether the state of steady sliding depends on one of the parameters."""
        moving = self.driver.pencil.at_rest().names
        return self.scene.slides_steadily and not moving.isdisjoint(names)

    def modes(
        self,
        changes: Mapping[str, Any] | None = None,
        *,
        left: bool = False,
        listener: Callable[[str], None] | None = None,
        **of_every_contact: Any,
    ) -> Result:
        """Compute the modes of the scene with fields changed.

        Parameters
        ----------
        changes
            Values by path, as in :meth:`scenes.spec.reading.Scene.change`.
        left
            Whether to compute left eigenvectors too, for sensitivities.
        listener
            Called with the name of each stage as it begins.
        of_every_contact
            Fields of every contact that is not bonded, e.g. ``mu = 0.3``.

        Raises
        ------
        SceneError
            If a changed scene is invalid.
        InputError
            If the kind of analysis is changed, or fields are given but all contacts are bonded.
        """
        sliding = [name for name in self.scene.contacts if name not in self.bonded]
        every: dict[str, Any] = {}
        for field_, value in of_every_contact.items():
            if not sliding:
                raise InputError(field_, value, "left out: the scene has no contact that can slide")
            every |= {f"contacts.{name}.{field_}": value for name in sliding}
        every |= changes or {}
        scene = self.scene.change(every)
        values = parameters_changed(self.driver.pencil, self.scene, scene, every)
        return self._modes(scene, values, left=left, listener=listener)

    def modes_at(
        self,
        values: Mapping[str, float],
        *,
        left: bool = False,
        listener: Callable[[str], None] | None = None,
    ) -> Result:
        """Compute the modes at parameters of the pencil, by name as in :meth:`threshold`.

        If the field is an expression, the parameter is a factor on it, whereas :meth:`modes`
        replaces it by a number. Raises a SceneError for values that a scene may not have, and an
        InputError for unknown parameters.
        """
        scene = at_parameters(self.scene, self.driver.pencil, values)
        return self._modes(scene, values, left=left, listener=listener)

    def _modes(
        self,
        scene: Scene,
        values: Mapping[str, float] | None,
        *,
        left: bool,
        listener: Callable[[str], None] | None,
    ) -> Result:
        """Compute the modes of a scene, from the assembled pencil if it is valid at ``values``."""
        if values is None or not self._holds_at(values):
            return run_modes(scene, left=left, bodies=self.bodies, listener=listener)
        return solved(scene, self._system, StageTimer(listener), self.driver, values, left=left)

    def warnings(
        self, modes: Modes, max_frequency: float, values: Mapping[str, float]
    ) -> tuple[ResultWarning, ...]:
        """Return the warnings about modes up to a frequency (Hz) at parameters; collective."""
        scene = at_parameters(self.scene, self.driver.pencil, values)
        inside = modes[np.flatnonzero(modes.frequencies <= max_frequency)]
        return result_of_modes(scene, self._system, StageTimer(), inside).warnings

    def threshold(
        self, parameter: str, real: float, flutter: float, *, frequency: float | None = None
    ) -> ConfirmedThreshold:
        """Return the first value of a parameter at which a pair of modes begins to flutter.

        With damping or rotation it is where a growth rate crosses zero. Thresholds are located with
        a reduced model between both values and confirmed by full solves. If the state of steady
        sliding depends on the parameter, state and modes are recomputed at every value, and the
        threshold is bisected in the first quarter of the interval at whose end a mode grows.

        Parameters
        ----------
        parameter
            Path of a parameter of the pencil: mu or P of a contact, E or rho of a body, e.g.
            ``contacts.pad_disc.mu``, ``bodies.disc.damping.alpha``, ``bodies.disc.rotation.rate``,
            ``contacts.pad_disc.sliding.speed``; a factor if the field is an expression. An asterisk
            matches every name: ``contacts.*.mu`` sets mu of all contacts to the same value.
        real, flutter
            Ends of the search interval; the search starts at ``real``.
        frequency
            Select the threshold closest to this frequency (Hz); by default the first one.

        Raises
        ------
        InputError
            If there is no such parameter, or no mode begins to grow between the values.
        ConvergenceError
            If the spectra do not determine a threshold, or no state of steady sliding is found.
        """
        names = parameters_meant(self.driver.pencil, parameter)
        if self.depends_on_state(names):
            allowed = "left out where the state of steady sliding depends on the parameter"
            require(frequency is None, "frequency", frequency, allowed)
            return self._bisected_threshold(names, real, flutter)
        saddle = in_saddle_form(self.scene)
        other = self if saddle == self.scene else AssembledScene(saddle)
        top = self.scene.window.max_frequency
        try:
            found = first_threshold(
                other.driver, names, real, flutter, max_frequency=top, frequency=frequency
            )
            at = dict.fromkeys(names, found.value)
            changed = at_parameters(other.scene, other.driver.pencil, at)
            told = system_warnings(changed, other._system, at)
        finally:
            if other is not self:
                other.free()
        return replace(found, warnings=(*found.warnings, *told))

    def _bisected_threshold(
        self, names: Sequence[str], real: float, flutter: float
    ) -> ConfirmedThreshold:
        """Return a threshold by bisection; recompute the state of steady sliding at each value."""

        def at(value: float) -> tuple[Result, bool]:
            scene = at_parameters(self.scene, self.driver.pencil, dict.fromkeys(names, value))
            result = run_modes(scene, bodies=self.bodies)
            return result, bool(result.modes.unstable(threshold=0.0).any())

        low = real
        for high in np.linspace(real, flutter, _SAMPLES).tolist():
            found, grows = at(high)
            if grows:
                break
            low = high
        if low == high:  # a mode grows at ``real``, or none does
            allowed = f"a value such that a mode begins to grow between {real:g} and it"
            raise InputError("flutter", flutter, allowed)
        while abs(high - low) > _RESOLVED * abs(high):
            middle = 0.5 * (low + high)
            between, grows = at(middle)
            if grows:
                found, high = between, middle
            else:
                low = middle
        fastest = complex(found.eigenvalues[found.growth_rates.argmax()])
        return ConfirmedThreshold(", ".join(names), high, fastest, found.warnings)

    def _holds_at(self, values: Mapping[str, float]) -> bool:
        """Whether the assembled system equals that of a fresh run at parameters."""
        try:
            self.driver.pencil.values(values)
        except InputError:
            return False
        left_open = [name for name, each in self.scene.contacts.items() if each.form is None]
        same = all(self._system.keeps_form(name, values) for name in left_open)
        return same and not self.depends_on_state(list(values))

    def free(self) -> None:
        """Free the factors that are kept between solves."""
        self.driver.free()


def assemble(scene: Scene, listener: Callable[[str], None] | None = None) -> AssembledScene:
    """Return an :class:`AssembledScene`; parameters and errors are those of the class."""
    return AssembledScene(scene, listener)
