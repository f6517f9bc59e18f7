"""What is swept: a scene whose pencil is solved at points, or that is run in full at each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import InputError, ResultWarning
from comparisons.sweep.points import Field, Points, table_of
from scenes import Result
from scenes.running.assembled import AssembledScene
from scenes.running.matrices import AssembledMatrices
from scenes.running.swept import (
    in_saddle_form,
    means_several,
    no_two_alike,
    parameters_meant,
    stiffnesses_meant,
)
from scenes.spec.contact import ContactSpec
from scenes.spec.matrices import load_matrices
from scenes.spec.plain import as_data, is_of_matrices
from scenes.spec.problems import SceneError
from scenes.spec.reading import load_scene

Assembled = AssembledScene | AssembledMatrices
"""A scene that is solved at changed fields."""
Warnings = Callable[[Modes, Mapping[str, float]], tuple[ResultWarning, ...]]
"""What modes must be read with at some parameters."""


class NoMapError(InputError):
    """A scene without a reduced model over some fields; it may be solved in full at each point."""


@dataclass(frozen=True)
class Mapped:
    """A scene whose pencil is solved at points.

    ``names`` are the parameters of the pencil that each field means, and the factor of each on its
    values: P of a contact has one where the field is p. The scene as plain data, its window (Hz,
    1/s) and limit of growth (1/s); what modes must be read with at some parameters.
    """

    driver: EigenSolver
    points: Points
    names: tuple[Mapping[str, float], ...]
    scene: Mapping[str, Any]
    max_frequency: float
    growth_threshold: float | None
    min_growth: float | None
    warnings: Warnings

    @property
    def pencil(self) -> Pencil:
        """The pencil."""
        return self.driver.pencil

    def point(self, values: Sequence[float]) -> dict[str, float]:
        """Parameters at a value of each field."""
        pairs = zip(values, self.names, strict=True)
        return {
            name: factor * float(value) for value, names in pairs for name, factor in names.items()
        }


def mapped(
    scene: str | Path,
    fields: Sequence[Field],
    overrides: Sequence[str] = (),
    data: str | None = None,
    samples: tuple[int, int] = (0, 0),
) -> Mapped:
    """Assemble a scene with forces of its contacts as unknowns.

    ``samples`` are the number of samples of distributions and their seed. NoMapError is raised when
    a field is no parameter of the pencil, or the pencil is not that of all points, or has no
    reduced model; InputError when the scene is refused, or a value.
    """
    assembled: Assembled
    if is_of_matrices(scene):
        assembled = AssembledMatrices(load_matrices(scene, list(overrides), data))
        names = _names(assembled.driver.pencil, fields, {}, ())
    else:
        _refuse_data(data)
        assembled = AssembledScene(in_saddle_form(load_scene(scene, list(overrides))))
        contacts, bonded = assembled.scene.contacts, assembled.bonded
        names = _names(assembled.driver.pencil, fields, contacts, bonded)
        for name in (name for each in names for name in each):
            if assembled.depends_on_state([name]):
                assembled.free()
                raise NoMapError("axis", name, "no parameter that moves a state of steady sliding")
    driver, window, least = assembled.driver, assembled.scene.window, list[float]()

    def warnings(modes: Modes, at: Mapping[str, float]) -> tuple[ResultWarning, ...]:
        if isinstance(assembled, AssembledMatrices):
            return modes.warnings
        return assembled.warnings(modes, window.max_frequency, at)

    for each in names:
        meant = [driver.pencil.parameter(name) for name in each]
        signed, positive = all(p.signed for p in meant), any(p.positive for p in meant)
        least.append(-np.inf if signed else np.finfo(float).tiny if positive else 0.0)
    points = table_of(fields, least, *samples)
    given = window.max_frequency, window.growth_threshold, window.min_growth
    found = Mapped(driver, points, names, as_data(assembled.scene), *given, warnings)
    for values in (found.point(each) for each in zip(*points.ends, strict=True)):
        for name, value in values.items():
            driver.pencil.parameter(name).check(value)
        try:  # modes that are damped one by one may be others there
            driver.pencil.check(values)
        except InputError as error:
            raise no_map(error) from error
    return found


def _refuse_data(data: str | None) -> None:
    if data is not None:
        raise InputError("data", data, "left out: a scene of bodies reads no matrices")


def _names(
    pencil: Pencil,
    fields: Sequence[Field],
    contacts: Mapping[str, ContactSpec],
    bonded: Sequence[str],
) -> tuple[Mapping[str, float], ...]:
    """Parameters that fields mean; P of contacts for each unit of p that they have in the scene."""
    found: list[Mapping[str, float]] = []
    p = [stiffnesses_meant(contacts, field.name) for field in fields]
    try:
        for field, own in zip(fields, p, strict=True):
            paths = {f"contacts.{contact}.P": value for contact, value in own.items()}
            of_p = {path: pencil.parameter(path).value / value for path, value in paths.items()}
            meant = of_p or dict.fromkeys(parameters_meant(pencil, field.name, bonded), 1.0)
            found.append(meant)
    except InputError as error:
        raise no_map(error) from error
    no_two_alike(found, [field.name for field in fields])
    return tuple(found)


def no_map(error: InputError) -> NoMapError:
    """A refusal that leaves full solves."""
    return NoMapError(error.field, error.value, error.allowed)


class InFull:
    """A scene that is run at each point of some axes, its state of steady sliding sought anew."""

    def __init__(
        self, scene: str | Path, fields: Sequence[Field], overrides: Sequence[str], data: str | None
    ) -> None:
        self.points = table_of(fields, [-np.inf] * len(fields), 0, 0)
        names = self.points.names
        first = zip(names, self.points.values[0].tolist(), strict=True)
        at_first = [*overrides, *(f"{n}={value!r}" for n, value in first if not means_several(n))]
        self._assembled: Assembled
        stiffnesses, bonded = [dict[str, float]() for _ in names], list[str]()
        if is_of_matrices(scene):
            self._assembled = AssembledMatrices(load_matrices(scene, at_first, data))
        else:
            _refuse_data(data)
            try:
                read = load_scene(scene, list(overrides))
            except SceneError:  # a field may be given by the sweep alone
                read = load_scene(scene, at_first)
            stiffnesses = [stiffnesses_meant(read.contacts, name) for name in names]
            self._assembled = AssembledScene(read)
            bonded = self._assembled.bonded
        self._paths = []
        values = self.points.values[0].tolist()
        for name, value, p in zip(names, values, stiffnesses, strict=True):
            meant = [f"contacts.{contact}.p" for contact in p] or [name]
            if means_several(name) and not p:
                try:
                    meant = parameters_meant(self._assembled.driver.pencil, name, bonded)
                except InputError as error:
                    raise InputError(name, value, error.allowed) from error
            self._paths.append(meant)
        no_two_alike(self._paths, names)

    def run(self, values: Sequence[float]) -> Result:
        """Modes at a value of each field; of parameters as maps take them."""
        pairs = zip(values, self._paths, strict=True)
        changed = {path: float(value) for value, paths in pairs for path in paths}
        assembled = self._assembled
        known = set(changed) <= set(assembled.driver.pencil.parameters)
        if isinstance(assembled, AssembledScene) and known:
            return assembled.modes_at(changed)
        return assembled.modes(changed)

    def free(self) -> None:
        """Free factors."""
        self._assembled.free()
