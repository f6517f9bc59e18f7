"""A scene assembled once and solved many times: sweeps over friction, stiffness, materials.

A field of the scene is a parameter of the assembled pencil if the pencil has one with the path of
the field and its value: the pencil then depends on the field through coefficients alone.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import isclose, isfinite
from typing import Any

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import InputError, ResultWarning, require
from cea.reduced.full_solves import ConfirmedThreshold, first_threshold
from cea.timing import StageTimer
from scenes.results.result import Result
from scenes.running.run import coupled, result_of_modes, run_modes, solved, system_warnings
from scenes.spec.contact import ContactSpec
from scenes.spec.reading import Scene

_SAMPLES = 5
"""Number of values at which unstable modes are sought to bracket a threshold before bisection."""
_RESOLVED = 1e-8
"""Relative width of the bracket at which bisection ends."""
_SHORT = {
    "mu": "contacts.*.mu",
    "P": "contacts.*.P",
    "p": "contacts.*.p",
    "E": "bodies.*.material.E",
    "rho": "bodies.*.material.rho",
    "alpha": "bodies.*.damping.alpha",
    "beta": "bodies.*.damping.beta",
    "Omega": "bodies.*.rotation.rate",
}
"""Short names of fields of all contacts or all bodies."""
_OF_EACH_SOLVE = (
    "analysis.max_frequency",
    "analysis.min_growth",
    "analysis.growth_threshold",
    "name",
    "description",
    "output.pictures",
    "output.paraview",
)
"""Fields that do not affect the pencil; a change of any other field needs a new assembly."""
_ROUNDING = 1e-12
"""Relative tolerance between a parameter, which may be a sum over points, and its field."""


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
        begins = low != high  # else a mode grows at ``real``, or none does
        allowed = f"a value such that a mode begins to grow between {real:g} and it"
        require(begins, "flutter", flutter, allowed)
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


def means_several(name: str) -> bool:
    """Whether a name is a short name or contains asterisks."""
    return name in _SHORT or "*" in name


def _meant(name: str, path: str, bonded: Iterable[str]) -> bool:
    """Whether a name matches a path; asterisks match names, short names skip bonded contacts."""
    pattern = re.escape(_SHORT.get(name, name)).replace(r"\*", r"[^.]+")
    aside = name in _SHORT and any(path.startswith(f"contacts.{each}.") for each in bonded)
    return re.fullmatch(pattern, path) is not None and not aside


def parameters_meant(pencil: Pencil, name: str, bonded: Iterable[str] = ()) -> list[str]:
    """Return the parameters of a pencil that a name matches."""
    found = [each for each in pencil.parameters if _meant(name, each, bonded)]
    there = ", ".join(sorted(pencil.parameters)) or "none"
    allowed = f"one of {there}; for others cea sweep ... --full solves each value in full"
    require(bool(found), "parameter", _SHORT.get(name, name), allowed)
    return found


def stiffnesses_meant(contacts: Mapping[str, ContactSpec], name: str) -> dict[str, float]:
    """Return p of each contact whose field p a name matches; P is proportional to it."""
    bonded = [each for each, spec in contacts.items() if spec.formulation.coupling == "bonded"]
    found = {}
    for each, spec in contacts.items():
        path = f"contacts.{each}.p"
        if _meant(name, path, bonded):
            if not isinstance(spec.p, float) or not isfinite(spec.p):
                allowed = f"a finite number in the scene, or contacts.{each}.P or c_n instead"
                raise InputError(path, spec.p, allowed)
            found[each] = spec.p
    return found


def in_saddle_form(scene: Scene) -> Scene:
    """Return the scene with pointwise contacts in saddle form, which loses no digits."""
    contacts = scene.contacts.items()
    pointwise = [name for name, each in contacts if each.formulation.coupling == "pointwise"]
    return scene.change({f"contacts.{name}.form": "saddle" for name in pointwise})


def no_two_alike(groups: Sequence[Iterable[str]], names: Sequence[str]) -> None:
    """Raise an InputError if two axes match the same parameter."""
    seen: dict[str, int] = {}
    for number, (group, name) in enumerate(zip(groups, names, strict=True)):
        for each in group:
            first = seen.setdefault(each, number)
            allowed = f"other parameters than {names[first]}: {each}"
            require(first == number, "axis", name, allowed)


def parameters_changed(
    pencil: Pencil, old: Scene, new: Scene, paths: Iterable[str]
) -> dict[str, float] | None:
    """Return the parameters at which the pencil is that of the changed scene; None if none are."""
    values: dict[str, float] = {}
    for path in paths:
        parameter = pencil.parameters.get(path)
        if parameter is not None:
            before, after = _field(old, path), _field(new, path)
            numbers = isinstance(before, float) and isinstance(after, float)
            if not (numbers and isclose(parameter.value, before, rel_tol=_ROUNDING)):
                return None
            values[path] = after
        elif path not in _OF_EACH_SOLVE:
            return None
    return values


def factors_among(scene: Scene, pencil: Pencil, names: Iterable[str]) -> list[str]:
    """Return the parameters that are factors on expressions or tables of the scene."""
    # The parameter of an expression that is constant is its value.
    given = {name: _field(scene, name) for name in names}
    varying = [name for name, field in given.items() if isinstance(field, str | tuple)]
    return [name for name in varying if pencil.parameter(name).value == 1.0]


def at_parameters(scene: Scene, pencil: Pencil, values: Mapping[str, float]) -> Scene:
    """Return the scene whose pencil equals that of ``scene`` at the given parameters."""
    bodies = dict(scene.bodies)
    for name in {path.split(".")[1] for path in values if ".damping." in path}:
        damping = bodies[name].damping
        bodies[name] = replace(bodies[name], damping=damping and damping.in_factors)
    scene = replace(scene, bodies=bodies)
    changes: dict[str, Any] = {}
    for name, value in values.items():
        own, field, of_p = pencil.parameter(name).value, _field(scene, name), f"{name[:-1]}p"
        if field is not None:
            changes[name] = _scaled(field, value, own)
        elif isinstance(p := _field(scene, of_p), float):
            changes |= {name: value, of_p: None}
        else:
            changes[of_p] = _scaled(p, value, own)
    return scene.change(changes)


def _scaled(field: Any, value: float, own: float) -> Any:
    """Return a field with its parameter changed from ``own`` to ``value``."""
    if own == 0 or isinstance(field, float):
        return value
    factor = value / own
    if isinstance(field, tuple):
        return [factor * each for each in field]
    return f"{factor!r}*({field})"


def _field(scene: Scene, path: str) -> Any:
    """Return the value of a field of a body or a contact; None if its section is missing."""
    section, name, *fields = path.split(".")
    found: Any = getattr(scene, section)[name]
    for field in fields:
        found = getattr(found, field, None)
    return found
