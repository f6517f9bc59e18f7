"""Scene of a sweep, whose pencil is solved at points, or which is run in full at each point."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import InputError, ResultWarning, require
from comparisons.sweep.points import Field, Points, table_of
from scenes import Result
from scenes.running.assembled import (
    AssembledScene,
    factors_among,
    in_saddle_form,
    means_several,
    no_two_alike,
    parameters_meant,
    stiffnesses_meant,
)
from scenes.running.matrices import AssembledMatrices
from scenes.spec.contact import ContactSpec
from scenes.spec.matrices import load_matrices
from scenes.spec.plain import is_of_matrices
from scenes.spec.reading import ComplexEigenvalueAnalysis, load_scene

Assembled = AssembledScene | AssembledMatrices
"""An assembled scene, solved with changed fields."""


class NoMapError(InputError):
    """A scene has no reduced model over some fields; full solves at each point may be possible."""


@dataclass(frozen=True)
class SweptScene:
    """A scene that is solved at points.

    ``names`` maps, for each field, the parameters of the pencil that it sets to factors on its
    values; a factor differs from one where the field p of a contact sets its P. For full solves the
    names may be fields that are not parameters.
    """

    assembled: Assembled
    points: Points
    names: tuple[Mapping[str, float], ...]

    @property
    def window(self) -> ComplexEigenvalueAnalysis:
        """Analysis that defines the window of modes."""
        return self.assembled.scene.window

    @property
    def driver(self) -> EigenSolver:
        """Eigenvalue driver of the pencil."""
        return self.assembled.driver

    @property
    def pencil(self) -> Pencil:
        """The parametric pencil."""
        return self.driver.pencil

    def point(self, values: Sequence[float]) -> dict[str, float]:
        """Return the parameters at given values of the fields."""
        pairs = zip(values, self.names, strict=True)
        return {
            name: factor * float(value) for value, names in pairs for name, factor in names.items()
        }

    @property
    def _of_pencil(self) -> bool:
        """Whether all fields are parameters of the pencil."""
        return all(set(names) <= set(self.pencil.parameters) for names in self.names)

    def factors_on(self, names: Iterable[str]) -> list[str]:
        """Return those of the names whose expressions in the scene a field multiplies."""
        if isinstance(self.assembled, AssembledMatrices) or not self._of_pencil:
            return []
        return factors_among(self.assembled.scene, self.pencil, names)

    def warnings(self, modes: Modes, at: Mapping[str, float]) -> tuple[ResultWarning, ...]:
        """Return the warnings about modes at given parameters."""
        if isinstance(self.assembled, AssembledMatrices):
            return modes.warnings
        return self.assembled.warnings(modes, self.window.max_frequency, at)

    def run(self, values: Sequence[float]) -> Result:
        """Return the modes at given values of the fields, with a new state of steady sliding."""
        changed = self.point(values)
        if isinstance(self.assembled, AssembledScene) and self._of_pencil:
            return self.assembled.modes_at(changed)
        return self.assembled.modes(changed)


def mapped(
    scene: str | Path,
    fields: Sequence[Field],
    overrides: Sequence[str] = (),
    data: str | None = None,
    samples: tuple[int, int] = (0, 0),
) -> SweptScene:
    """Assemble a scene for a reduced model, with contact forces as unknowns.

    ``samples`` are the number of samples of distributions and their seed. NoMapError when a field
    is not a parameter of the pencil, or the pencil changes with it in another way (steady sliding,
    modal damping); InputError when the scene or a value is not allowed.
    """
    assembled, contacts, bonded = _assembled(scene, overrides, data, saddle=True)
    pencil, names, least = assembled.driver.pencil, list[Mapping[str, float]](), list[float]()
    for field in fields:
        names.append(_factors(pencil, contacts, bonded, field.name))
        meant = [pencil.parameter(name) for name in names[-1]]
        signed, positive = all(e.signed for e in meant), any(e.positive for e in meant)
        least.append(-np.inf if signed else np.finfo(float).tiny if positive else 0.0)
        if isinstance(assembled, AssembledScene) and assembled.depends_on_state(list(names[-1])):
            allowed = "a parameter on which the state of steady sliding does not depend"
            raise NoMapError("axis", field.name, allowed)
        if any(each.fixed for each in meant):
            allowed = "another parameter than those at which modal damping was computed"
            raise NoMapError("axis", field.name, allowed)
    no_two_alike(names, [field.name for field in fields])
    found = SweptScene(assembled, table_of(fields, least, *samples), tuple(names))
    for values in zip(*found.points.ends, strict=True):
        pencil.values(found.point(values))
    return found


def in_full(
    scene: str | Path, fields: Sequence[Field], overrides: Sequence[str], data: str | None
) -> SweptScene:
    """Assemble a scene for full solves at each point of axes."""
    assembled, contacts, bonded = _assembled(scene, overrides, data, saddle=False)
    points, names = table_of(fields, [-np.inf] * len(fields), 0, 0), list[Mapping[str, float]]()
    for name in points.names:
        meant = [f"contacts.{contact}.p" for contact in stiffnesses_meant(contacts, name)]
        if not meant and means_several(name):
            meant = parameters_meant(assembled.driver.pencil, name, bonded)
        names.append(dict.fromkeys(meant or [name], 1.0))
    no_two_alike(names, points.names)
    return SweptScene(assembled, points, tuple(names))


def _assembled(
    scene: str | Path, overrides: Sequence[str], data: str | None, *, saddle: bool
) -> tuple[Assembled, Mapping[str, ContactSpec], Sequence[str]]:
    """Return an assembled scene, its contacts, and the names of bonded ones."""
    if is_of_matrices(scene):
        return AssembledMatrices(load_matrices(scene, list(overrides), data)), {}, ()
    require(data is None, "data", data, "left out: a scene of bodies reads no matrices")
    read = load_scene(scene, list(overrides))
    assembled = AssembledScene(in_saddle_form(read) if saddle else read)
    return assembled, assembled.scene.contacts, assembled.bonded


def _factors(
    pencil: Pencil, contacts: Mapping[str, ContactSpec], bonded: Sequence[str], name: str
) -> dict[str, float]:
    """Return the parameters that a field sets, to factors on its value; NoMapError without any."""
    own = stiffnesses_meant(contacts, name)
    paths = {f"contacts.{contact}.P": p for contact, p in own.items()}
    try:
        of_p = {path: pencil.parameter(path).value / p for path, p in paths.items()}
        return of_p or dict.fromkeys(parameters_meant(pencil, name, bonded), 1.0)
    except InputError as error:
        raise NoMapError(error.field, error.value, error.allowed) from error
