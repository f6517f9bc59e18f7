"""A scene assembled once and solved many times: sweeps over friction, stiffness, materials."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from cea.body import Body
from cea.eigen.krylov_schur import KrylovSchur
from cea.eigen.thresholds import Threshold, flutter_threshold
from cea.errors import InputError
from cea.timing import StageTimer
from scenes.read import Scene
from scenes.results import ModesResult
from scenes.run import RunOptions, coupled, run_modes, skipped_by, with_warnings
from scenes.spec import BodySpec, ComplexEigenvalueAnalysis, ContactSpec


class AssembledScene:
    """A scene whose matrices are the pieces of a parametric pencil.

    Modes at another E or rho of a body, P or mu of a contact need no assembly. Other changes build
    again what they touch: bodies, contact points, or the contact matrices alone.

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
            Fields of every contact, e.g. ``mu = 0.3``.

        Raises
        ------
        SceneError
            When a change is refused.
        InputError
            When the analysis is changed to another.
        """
        every = {
            f"contacts.{name}.{field}": value
            for name in self.scene.contacts
            for field, value in of_every_contact.items()
        }
        scene = self.scene.change(every | dict(changes or {}))
        values = self._parameters_changed(scene)
        if values is None or not isinstance(scene.analysis, ComplexEigenvalueAnalysis):
            options: RunOptions = {"listener": listener, **self._reusable(scene)}
            return run_modes(scene, left=left, **options)
        timer = StageTimer(listener)
        modes = self._driver.solve(scene.analysis.max_frequency, values, left=left, timer=timer)
        result = ModesResult(scene, self._system, self.interfaces, timer, skipped_by(scene), modes)
        return with_warnings(result)

    def threshold(
        self, parameter: str, real: float, flutter: float, *, frequency: float | None = None
    ) -> Threshold:
        """Value of a parameter at which a pair of modes begins to flutter, or ceases to.

        Parameters
        ----------
        parameter
            Path of mu or P of a contact, of E or rho of a body, e.g. ``contacts.pad_disc.mu``; a
            factor where the field is an expression.
        real, flutter
            Values on either side: at one the pair does not grow, at the other it does.
        frequency
            The growing mode nearest to it (Hz) is followed; None follows the fastest.

        Raises
        ------
        InputError
            When there is no such parameter, or the values do not enclose a threshold.
        ConvergenceError
            When the pair is lost on the way.
        """
        assert isinstance(self.scene.analysis, ComplexEigenvalueAnalysis)
        top = self.scene.analysis.max_frequency
        return flutter_threshold(
            self._driver, parameter, real, flutter, max_frequency=top, frequency=frequency
        )

    def _parameters_changed(self, scene: Scene) -> dict[str, float] | None:
        """Parameters that make this scene another; None where others differ, or forms would."""
        values = _parameters_changed(self.scene, scene)
        if scene.slides_steadily and not all(name.endswith(".rho") for name in values or ()):
            return None  # another state of steady sliding
        left_open = [name for name, contact in scene.contacts.items() if contact.form is None]
        if values is not None and self._system.keeps_forms(left_open, values):
            return values
        return None

    def _reusable(self, scene: Scene) -> RunOptions:
        """What a changed scene shares with this one."""
        if (scene.bodies, scene.loads) != (self.scene.bodies, self.scene.loads):
            return {}
        if not _same_points(self.scene, scene):
            return {"bodies": self.bodies}
        return {"bodies": self.bodies, "interfaces": self.interfaces}

    def free(self) -> None:
        """Free factors kept between solves."""
        self._driver.free()


def assemble(scene: Scene, listener: Callable[[str], None] | None = None) -> AssembledScene:
    """Assemble a scene to be solved many times; parameters and errors of the class."""
    return AssembledScene(scene, listener)


def _parameters_changed(old: Scene, new: Scene) -> dict[str, float] | None:
    """Parameters of the pencil that make the one scene the other; None where others differ."""
    if old.bodies.keys() != new.bodies.keys() or old.contacts.keys() != new.contacts.keys():
        return None
    values: dict[str, float] = {}
    for name, body in old.bodies.items():
        found = _of_body(body, new.bodies[name])
        if found is None:
            return None
        values |= {f"bodies.{name}.material.{key}": value for key, value in found.items()}
    for name, contact in old.contacts.items():
        found = _of_contact(contact, new.contacts[name])
        if found is None:
            return None
        values |= {f"contacts.{name}.{key}": value for key, value in found.items()}
    return values


def _of_body(old: BodySpec, new: BodySpec) -> dict[str, float] | None:
    E, rho = new.material.E, new.material.rho
    if rho is None or replace(old, material=replace(old.material, E=E, rho=rho)) != new:
        return None
    found = {"E": E, "rho": rho}
    return {key: value for key, value in found.items() if value != getattr(old.material, key)}


def _of_contact(old: ContactSpec, new: ContactSpec) -> dict[str, float] | None:
    """Changes of P and mu; where these are expressions, parameters are factors on them."""
    if not _alike(old, new, ("P", "mu")):
        return None
    found = {}
    for key in ("P", "mu"):
        before, after = getattr(old, key), getattr(new, key)
        if before != after:
            if not (isinstance(before, float) and isinstance(after, float)):
                return None
            found[key] = after
    return found


_LAW = ("P", "p", "c_n", "m_n", "added_gap", "mu", "friction_direction_on_a", "form")
"""Fields of a contact on which its points do not depend."""


def _same_points(old: Scene, new: Scene) -> bool:
    return old.contacts.keys() == new.contacts.keys() and all(
        _alike(contact, new.contacts[name], _LAW) for name, contact in old.contacts.items()
    )


def _alike(old: ContactSpec, new: ContactSpec, but: Sequence[str]) -> bool:
    """Whether all fields but some are equal."""
    return all(
        getattr(old, field.name) == getattr(new, field.name)
        for field in fields(ContactSpec)
        if field.name not in but
    )
