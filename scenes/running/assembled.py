"""A scene assembled once and solved many times: sweeps over friction, stiffness, materials."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cea.arrays import Complexes
from cea.eigen.block_products import all_inner, times
from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil, internal_forces, release
from cea.errors import ConvergenceError, InputError, ResultWarning
from cea.reduced.full_solves import (
    ConfirmedThreshold,
    first_threshold,
    line_in_full,
    threshold_between,
)
from cea.reduced.window import Window
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from scenes.results.result import Result
from scenes.running.modes import result_of_modes, run_modes, solved
from scenes.running.swept import at_parameters, in_saddle_form, parameters_changed, parameters_meant
from scenes.running.system import RunOptions, coupled, system_warnings
from scenes.spec.reading import Scene

_STEP = 1e-5
"""Step of difference quotients of matrices, relative to the value."""


class AssembledScene:
    """A scene whose matrices are the pieces of a parametric pencil.

    Modes of the scene with fields changed are those of a fresh run. At another E or rho, damping or
    rate of rotation of a body, at another P or mu, pressure, speed or slope of friction of a
    contact, that needs no assembly, as far as the state of steady sliding and the forms of contacts
    stay. Other changes build again what they touch: bodies, contact points, the state of steady
    sliding, or the contact matrices alone.

    Parameters
    ----------
    scene
        A scene whose analysis asks for modes; another is refused with an InputError.
    listener
        Called with the name of each stage as it begins.

    Attributes
    ----------
    bodies, interfaces
        Its bodies by name, and its contact points by name of the half pass.
    driver
        What solves its pencil.
    timer
        Seconds that assembly took, by stage.
    """

    def __init__(self, scene: Scene, listener: Callable[[str], None] | None = None) -> None:
        self.scene = scene
        _ = scene.window  # refused where the analysis gives no modes
        # Friction is kept where mu = 0: a sweep may begin there.
        self._system, self.interfaces, self.timer = coupled(
            scene, leave_out=False, listener=listener
        )
        self.bodies = self._system.bodies
        self._built: RunOptions = {"bodies": self.bodies, "interfaces": self.interfaces}
        with self.timer("assembly"):
            self.driver = EigenSolver(self._system.pencil())

    @property
    def bonded(self) -> list[str]:
        """Contacts that cannot slide."""
        contacts = self.scene.contacts.items()
        return [name for name, each in contacts if each.formulation.coupling == "bonded"]

    def depends_on_state(self, names: Sequence[str]) -> bool:
        """Whether parameters move a state of steady sliding that the pencil is linearised about."""
        moving = self.driver.pencil.stiffness_parameters
        return self.scene.slides_steadily and not moving.isdisjoint(names)

    def modes(
        self,
        changes: Mapping[str, Any] | None = None,
        *,
        left: bool = False,
        listener: Callable[[str], None] | None = None,
        **of_every_contact: Any,
    ) -> Result:
        """Modes of the scene with fields changed.

        Parameters
        ----------
        changes
            Values by their paths, as :meth:`scenes.spec.reading.Scene.change` takes them.
        left
            Whether left eigenvectors are wanted too, for sensitivities.
        listener
            Called with the name of each stage as it begins.
        of_every_contact
            Fields of every contact that can slide, e.g. ``mu = 0.3``: bonded ones stay as they are.

        Raises
        ------
        SceneError
            When a change is refused.
        InputError
            When the analysis is changed to another, or no contact can slide.
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
        """Modes of the scene at parameters of its pencil, by name, as :meth:`threshold` takes them.

        Of a field that is an expression a parameter is a factor on it, where :meth:`modes` puts a
        number in its place. A SceneError refuses values that a scene may not have, an InputError
        what is no parameter.
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
        """Modes of another scene, that of the pencil at some parameters where these are given."""
        if values is None or not self._holds_at(values):
            options: RunOptions = {"listener": listener, **self._built}
            return run_modes(scene, left=left, **options)
        known = self._system, self.interfaces, StageTimer(listener)
        return solved(scene, *known, self.driver, values, left=left)

    def warnings(
        self, modes: Modes, max_frequency: float, values: Mapping[str, float]
    ) -> tuple[ResultWarning, ...]:
        """What modes up to a frequency (Hz) must be read with at other parameters; collective."""
        scene = at_parameters(self.scene, self.driver.pencil, values)
        inside = modes[np.flatnonzero(modes.frequencies <= max_frequency)]
        known = self._system, self.interfaces, StageTimer()
        return result_of_modes(scene, *known, inside).warnings

    def threshold(
        self, parameter: str, real: float, flutter: float, *, frequency: float | None = None
    ) -> ConfirmedThreshold:
        """The first value of a parameter at which a pair of modes begins to flutter.

        With damping or rotation it is where a growth rate passes through zero. Thresholds are
        sought on a reduced model between both values, and confirmed by full solves. Where the state
        of steady sliding depends on the parameter, both are sought anew at every value on the way.

        Parameters
        ----------
        parameter
            Path of a parameter of the pencil: mu or P of a contact, E or rho of a body, e.g.
            ``contacts.pad_disc.mu``, ``bodies.disc.damping.alpha``, ``bodies.disc.rotation.rate``,
            ``contacts.pad_disc.sliding.speed``; a factor where the field is an expression. An
            asterisk stands for every name: ``contacts.*.mu`` of all contacts, which have one value.
        real, flutter
            Values between which it is sought, the first one seen from ``real``.
        frequency
            The threshold nearest to it (Hz) is taken; None takes the first one.

        Raises
        ------
        InputError
            When there is no such parameter, or nothing begins to grow between the values.
        ConvergenceError
            When spectra do not tell of thresholds, or there is no state of steady sliding.
        """
        names = parameters_meant(self.driver.pencil, parameter)
        if self.depends_on_state(names):
            return self._followed_threshold(names, real, flutter, frequency)
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

    def _followed_threshold(
        self, names: Sequence[str], real: float, flutter: float, frequency: float | None
    ) -> ConfirmedThreshold:
        """A threshold with the state of steady sliding sought anew at every value on the way."""
        pencil = self.driver.pencil
        options: RunOptions = {"leave_out": False, **self._built}

        def at(value: float) -> tuple[Scene, CoupledSystem]:
            changed = at_parameters(self.scene, pencil, dict.fromkeys(names, value))
            return changed, coupled(changed, **options)[0]

        scale = max(abs(real), abs(flutter))

        def state(value: float, max_frequency: float) -> tuple[Modes, Complexes]:
            return _followed(lambda each: at(each)[1].pencil(), value, max_frequency, scale)

        window = Window.up_to(self.scene.window.max_frequency, damped=pencil.damped)
        found = threshold_between(line_in_full(state, window), real, flutter, frequency)
        told = tuple(system_warnings(*at(found.value)))
        return ConfirmedThreshold(", ".join(names), found.value, found.eigenvalue, told)

    def _holds_at(self, values: Mapping[str, float]) -> bool:
        """Whether state, pieces and forms of contacts are those of a fresh run at parameters."""
        try:
            self.driver.pencil.check(values)
        except InputError:
            return False
        left_open = [name for name, each in self.scene.contacts.items() if each.form is None]
        same = all(self._system.keeps_form(name, values) for name in left_open)
        return same and not self.depends_on_state(list(values))

    def free(self) -> None:
        """Free factors kept between solves."""
        self.driver.free()


def assemble(scene: Scene, listener: Callable[[str], None] | None = None) -> AssembledScene:
    """Assemble a scene to be solved many times; parameters and errors of the class."""
    return AssembledScene(scene, listener)


def _followed(
    pencil_at: Callable[[float], Pencil], value: float, max_frequency: float, scale: float
) -> tuple[Modes, Complexes]:
    """All modes up to a frequency (Hz) of a pencil linearised about steady sliding at a value.

    With left vectors, and derivatives of their lambda, made of difference quotients of the matrices
    over steps relative to a scale, shape (n,).
    """
    with EigenSolver(pencil_at(value)) as driver:
        modes = driver.solve(max_frequency, left=True)
    step = _STEP * scale
    low, high = (_works(pencil_at(value + way * step), modes) for way in (-1.0, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return modes, (low - high) / (2 * step) / (2 * modes.eigenvalues)


def _works(pencil: Pencil, modes: Modes) -> Complexes:
    """y^H P(lambda) x of another pencil at modes and their contact forces, shape (n,)."""
    assert modes.left is not None
    matrices, x, f = pencil.at(), modes.vectors, modes.forces
    y, g, roots = modes.left.vectors, modes.left.forces, modes.eigenvalues
    contacts = matrices.multipliers
    if len(f) != (0 if contacts is None else contacts.closure.getLocalSize()[0]):
        raise ConvergenceError("the form of a contact changes with the parameter: fix it")
    force = internal_forces(matrices, x, f) + times(matrices.mass, x) * roots**2
    works = np.diag(all_inner(y, force + matrices.drag(x) * roots, pencil.comm)).copy()
    if contacts is not None:
        gap = times(contacts.closure, x) - times(contacts.compliance, f)
        works += np.diag(all_inner(g, gap, pencil.comm))
    release(matrices)
    return works
