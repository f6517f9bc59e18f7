"""What is swept: a scene whose pencil is solved at points, or that is run in full at each."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil
from cea.errors import InputError, ResultWarning, require
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
from scenes.spec.plain import is_of_matrices
from scenes.spec.reading import ComplexEigenvalueAnalysis, load_scene

Assembled = AssembledScene | AssembledMatrices
"""A scene that is solved at changed fields."""


class NoMapError(InputError):
    """A scene without a reduced model over some fields; it may be solved in full at each point."""


@dataclass(frozen=True)
class SweptScene:
    """A scene that is solved at points.

    ``names`` are the parameters of its pencil that each field means, and the factor of each on its
    values: P of a contact has one where the field is p. Of a scene that is solved in full they may
    be fields that are no parameters.
    """

    assembled: Assembled
    points: Points
    names: tuple[Mapping[str, float], ...]

    @property
    def window(self) -> ComplexEigenvalueAnalysis:
        """The modes that are wanted."""
        return self.assembled.scene.window

    @property
    def driver(self) -> EigenSolver:
        """What solves its pencil."""
        return self.assembled.driver

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

    def warnings(self, modes: Modes, at: Mapping[str, float]) -> tuple[ResultWarning, ...]:
        """What modes must be read with at some parameters."""
        if isinstance(self.assembled, AssembledMatrices):
            return self.assembled.warnings(modes)
        return self.assembled.warnings(modes, self.window.max_frequency, at)

    def run(self, values: Sequence[float]) -> Result:
        """Modes at a value of each field, a state of steady sliding sought anew."""
        changed = self.point(values)
        known = set(changed) <= set(self.pencil.parameters)
        if isinstance(self.assembled, AssembledScene) and known:
            return self.assembled.modes_at(changed)
        return self.assembled.modes(changed)


def mapped(
    scene: str | Path,
    fields: Sequence[Field],
    overrides: Sequence[str] = (),
    data: str | None = None,
    samples: tuple[int, int] = (0, 0),
) -> SweptScene:
    """Assemble a scene with forces of its contacts as unknowns.

    ``samples`` are the number of samples of distributions and their seed. NoMapError is raised when
    a field is no parameter of the pencil, or the pencil is not that of all points, or has no
    reduced model; InputError when the scene is refused, or a value.
    """
    assembled, contacts, bonded = _assembled(scene, overrides, data, saddle=True)
    pencil, names, least = assembled.driver.pencil, list[Mapping[str, float]](), list[float]()
    for field in fields:
        own = stiffnesses_meant(contacts, field.name)
        paths = {f"contacts.{contact}.P": p for contact, p in own.items()}
        with _without_map():
            of_p = {path: pencil.parameter(path).value / p for path, p in paths.items()}
            names.append(of_p or dict.fromkeys(parameters_meant(pencil, field.name, bonded), 1.0))
        meant = [pencil.parameter(name) for name in names[-1]]
        signed, positive = all(e.signed for e in meant), any(e.positive for e in meant)
        least.append(-np.inf if signed else np.finfo(float).tiny if positive else 0.0)
        if isinstance(assembled, AssembledScene) and assembled.depends_on_state(list(names[-1])):
            allowed = "no parameter that moves a state of steady sliding"
            raise NoMapError("axis", field.name, allowed)
    no_two_alike(names, [field.name for field in fields])
    found = SweptScene(assembled, table_of(fields, least, *samples), tuple(names))
    for values in (found.point(each) for each in zip(*found.points.ends, strict=True)):
        for name, value in values.items():
            pencil.parameter(name).check(value)
        with _without_map():  # modes that are damped one by one may be others there
            pencil.check(values)
    return found


def in_full(
    scene: str | Path, fields: Sequence[Field], overrides: Sequence[str], data: str | None
) -> SweptScene:
    """Assemble a scene to be run at each point of some axes."""
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
    """A scene, its contacts, and those of them that cannot slide."""
    if is_of_matrices(scene):
        return AssembledMatrices(load_matrices(scene, list(overrides), data)), {}, ()
    require(data is None, "data", data, "left out: a scene of bodies reads no matrices")
    read = load_scene(scene, list(overrides))
    assembled = AssembledScene(in_saddle_form(read) if saddle else read)
    return assembled, assembled.scene.contacts, assembled.bonded


@contextmanager
def _without_map() -> Iterator[None]:
    """Refusals that leave full solves."""
    try:
        yield
    except InputError as error:
        raise NoMapError(error.field, error.value, error.allowed) from error
