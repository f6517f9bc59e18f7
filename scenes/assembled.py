"""A scene assembled once and solved many times: sweeps over friction, stiffness, materials."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cea.body import Body
from cea.eigen.growth_thresholds import growth_threshold
from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.modes import Modes
from cea.eigen.thresholds import Threshold, ThresholdDriver, flutter_threshold
from cea.errors import InputError
from cea.system.coupled import CoupledSystem
from cea.timing import StageTimer
from cea.warned import ResultWarning
from scenes.following import FollowingDriver, kept_state_warning, moves_the_state
from scenes.parameter_changes import parameters_changed, same_points
from scenes.read import Scene
from scenes.results import ModesResult
from scenes.run import RunOptions, coupled, run_modes, skipped_by, with_warnings
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.swept import parameters_meant


class AssembledScene:
    """A scene whose matrices are the pieces of a parametric pencil.

    Modes at another E or rho, damping or rate of rotation of a body, at another P or mu, pressure,
    speed or slope of friction of a contact need no assembly. Other changes build again what they
    touch: bodies, contact points, or the contact matrices alone.

    Parameters
    ----------
    scene
        A scene whose analysis asks for modes.
    listener
        Called with the name of each stage as it begins.

    Attributes
    ----------
    scene
        The scene.
    bodies
        Its bodies by name.
    interfaces
        Its contact points by name of the half pass.
    timer
        Seconds that assembly took, by stage.

    Raises
    ------
    InputError
        When the analysis is another.
    """

    def __init__(self, scene: Scene, listener: Callable[[str], None] | None = None) -> None:
        if not isinstance(scene.analysis, ComplexEigenvalueAnalysis):
            raise InputError("analysis.kind", scene.analysis.kind, "'cea', which gives modes")
        self.scene = scene
        # Friction is kept where mu = 0: a sweep may begin there.
        self._system, self.interfaces, self.timer = coupled(
            scene, leave_out=False, listener=listener
        )
        with self.timer("assembly"):
            self._driver = KrylovSchur(self._system.pencil())

    @property
    def bodies(self) -> Mapping[str, Body]:
        """Its bodies by name."""
        return self._system.bodies

    @property
    def driver(self) -> KrylovSchur:
        """What solves its pencil."""
        return self._driver

    @property
    def bonded(self) -> list[str]:
        """Contacts that cannot slide."""
        contacts = self.scene.contacts.items()
        return [name for name, each in contacts if each.formulation.coupling == "bonded"]

    def depends_on_state(self, names: Sequence[str]) -> bool:
        """Whether parameters move a state of steady sliding that the pencil is linearised about."""
        pencil = self._driver.pencil
        return self.scene.slides_steadily and any(moves_the_state(pencil, name) for name in names)

    def modes(
        self,
        changes: Mapping[str, Any] | None = None,
        *,
        left: bool = False,
        listener: Callable[[str], None] | None = None,
        **of_every_contact: Any,
    ) -> ModesResult:
        """Modes of the scene with fields changed.

        Parameters
        ----------
        changes
            Values by their paths, as :meth:`scenes.read.Scene.change` takes them.
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
        every = {
            f"contacts.{name}.{field}": value
            for name in _sliding(self.scene, of_every_contact)
            for field, value in of_every_contact.items()
        }
        scene = self.scene.change(every | dict(changes or {}))
        values = self._parameters_changed(scene)
        if values is None or not isinstance(scene.analysis, ComplexEigenvalueAnalysis):
            options: RunOptions = {"listener": listener, **self._reusable(scene)}
            return run_modes(scene, left=left, **options)
        timer = StageTimer(listener)
        top, decay = scene.analysis.max_frequency, scene.analysis.min_growth
        modes = self._driver.solve(top, values, min_growth=decay, left=left, timer=timer)
        result = ModesResult(scene, self._system, self.interfaces, timer, skipped_by(scene), modes)
        return with_warnings(result)

    def warnings(
        self, modes: Modes, max_frequency: float, values: Mapping[str, float]
    ) -> tuple[ResultWarning, ...]:
        """What modes up to a frequency must be read with, solved at other parameters; collective.

        Parameters
        ----------
        modes
            Modes of its pencil, perhaps of a longer window.
        max_frequency
            Frequency (Hz) up to which they count.
        values
            Parameters of the pencil that differ from their own values.
        """
        scene = self.scene.change(_numbers(self.scene, values))
        inside = np.flatnonzero(modes.frequencies <= max_frequency)
        result = ModesResult(
            *(scene, self._system, self.interfaces, StageTimer(), skipped_by(scene)),
            modes[inside],
        )
        return with_warnings(result).warnings

    def threshold(
        self,
        parameter: str,
        real: float,
        flutter: float,
        *,
        frequency: float | None = None,
        follow_steady_state: bool = False,
    ) -> Threshold:
        """Value of a parameter at which a pair of modes begins to flutter, or ceases to.

        With damping or rotation it is where the largest growth rate passes through zero.

        Parameters
        ----------
        parameter
            Path of a parameter of the pencil: mu or P of a contact, E or rho of a body, e.g.
            ``contacts.pad_disc.mu``, ``bodies.disc.damping.alpha``, ``bodies.disc.rotation.rate``,
            ``contacts.pad_disc.sliding.speed``; a factor where the field is an expression. An
            asterisk stands for every name: ``contacts.*.mu`` of all contacts, which have one value.
        real, flutter
            Values on either side: at one the pair does not grow, at the other it does; with damping
            every mode decays at the first.
        frequency
            The growing mode nearest to it (Hz) is followed; None follows the fastest. With damping
            or rotation it is left out.
        follow_steady_state
            Whether the state of steady sliding is sought anew at every value on the way, where it
            depends on the parameter; otherwise it is kept, and the threshold warns of it.

        Raises
        ------
        InputError
            When there is no such parameter, or the values do not enclose a threshold; when a state
            is to be followed that does not depend on the parameter.
        ConvergenceError
            When the pair is lost on the way, or there is no state of steady sliding.
        """
        names = parameters_meant(self._driver.pencil, parameter)
        depends = self.depends_on_state(names)
        if not follow_steady_state:
            found = self._threshold(self._driver, names, real, flutter, frequency)
            told = (kept_state_warning(parameter),) if depends else ()
            return replace(found, warnings=(*found.warnings, *told))
        if not depends:
            allowed = "left out where no state of steady sliding depends on the parameter"
            raise InputError("follow_steady_state", True, allowed)
        driver = FollowingDriver(
            self._driver.pencil, names, lambda value: self._system_at(names, value)
        )
        try:
            return self._threshold(driver, names, real, flutter, frequency)
        finally:
            driver.free()

    def _threshold(
        self,
        driver: ThresholdDriver,
        names: Sequence[str],
        real: float,
        flutter: float,
        frequency: float | None,
    ) -> Threshold:
        assert isinstance(self.scene.analysis, ComplexEigenvalueAnalysis)
        top = self.scene.analysis.max_frequency
        if self._quadratic(names, real, flutter):
            if frequency is not None:
                raise InputError("frequency", frequency, "left out with damping or rotation")
            return growth_threshold(driver, names, real, flutter, max_frequency=top)
        return flutter_threshold(
            driver, names, real, flutter, max_frequency=top, frequency=frequency
        )

    def _system_at(self, names: Sequence[str], value: float) -> CoupledSystem:
        """The system about the state of steady sliding that it has at a value of parameters."""
        changed = self.scene.change(dict.fromkeys(names, value))
        options: RunOptions = {"leave_out": False, **self._reusable(changed)}
        return coupled(changed, **options)[0]

    def _quadratic(self, names: Sequence[str], *values: float) -> bool:
        """Whether velocities count at some values of parameters."""
        if not self._driver.pencil.damped:
            return False
        return any(self._driver.quadratic(dict.fromkeys(names, value)) for value in values)

    def _parameters_changed(self, scene: Scene) -> dict[str, float] | None:
        """Parameters that make this scene another; None where others differ, or forms would."""
        values = parameters_changed(self.scene, scene)
        if scene.slides_steadily and (
            scene.analysis.load_steps != self.scene.analysis.load_steps
            or scene.stiffened_by_stress != self.scene.stiffened_by_stress
            or self.depends_on_state(list(values or ()))
        ):
            return None  # another state of steady sliding
        if values is not None and self.keeps_forms(scene, values):
            return values
        return None

    def keeps_forms(self, scene: Scene, values: Mapping[str, float]) -> bool:
        """Whether contacts whose form a scene leaves open keep theirs at some parameters."""
        left_open = [name for name, contact in scene.contacts.items() if contact.form is None]
        return self._system.keeps_forms(left_open, values)

    def _reusable(self, scene: Scene) -> RunOptions:
        """What a changed scene shares with this one."""
        if (scene.bodies, scene.loads) != (self.scene.bodies, self.scene.loads):
            return {}
        if not same_points(self.scene, scene):
            return {"bodies": self.bodies}
        return {"bodies": self.bodies, "interfaces": self.interfaces}

    def free(self) -> None:
        """Free factors kept between solves."""
        self._driver.free()


def _numbers(scene: Scene, values: Mapping[str, float]) -> dict[str, float | None]:
    """Parameters that are numbers of a scene; those that are factors on expressions are not.

    Where it gives p, uniform, P takes its place.
    """
    sections: dict[str, Mapping[str, Any]] = {"bodies": scene.bodies, "contacts": scene.contacts}
    found: dict[str, float | None] = {}
    for path, value in values.items():
        first, name, *fields = path.split(".")
        at: Any = sections[first][name]
        for field in fields:
            at = getattr(at, field, None)
        if isinstance(at, float):
            found[path] = value
        elif fields == ["P"] and isinstance(sections[first][name].p, float):
            found |= {path: value, f"{first}.{name}.p": None}
    return found


def assemble(scene: Scene, listener: Callable[[str], None] | None = None) -> AssembledScene:
    """Assemble a scene to be solved many times; parameters and errors of the class."""
    return AssembledScene(scene, listener)


def _sliding(scene: Scene, fields_of_all: Mapping[str, Any]) -> list[str]:
    """Contacts whose fields may be changed together: those that are not bonded."""
    names = [name for name, c in scene.contacts.items() if c.formulation.coupling != "bonded"]
    for field, value in fields_of_all.items():
        if not names:
            raise InputError(field, value, "left out: the scene has no contact that can slide")
    return names
