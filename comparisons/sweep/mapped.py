"""What is mapped: a scene, its pencil, and the axes as parameters of that."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Protocol

from cea.eigen.driver import EigenSolver
from cea.eigen.modes import Modes
from cea.eigen.pencil import Pencil, release
from cea.eigen.shifted import count_below
from cea.errors import InputError
from cea.reduced.norm import shift_of
from cea.reduced.pieces import check_pencil
from cea.warned import ResultWarning
from scenes.running.assembled import AssembledScene
from scenes.running.matrices import AssembledMatrices
from scenes.running.swept import no_two_alike, parameters_meant, stiffnesses_meant
from scenes.spec.analysis import ComplexEigenvalueAnalysis
from scenes.spec.contact import ContactSpec
from scenes.spec.files import is_of_matrices
from scenes.spec.matrices import load_matrices
from scenes.spec.plain import as_data
from scenes.spec.reading import load_scene


class Varied(Protocol):
    """A field whose values a map or samples have."""

    @property
    def name(self) -> str:
        """The field as it was given."""
        ...

    @property
    def values(self) -> list[float]:
        """The values."""
        ...

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest value."""
        ...

    @property
    def logarithmic(self) -> bool:
        """Whether values are evenly spaced in their logarithm."""
        ...


class NoMapError(InputError):
    """A scene that has no reduced model over some axes; it may be solved in full at each value."""


@dataclass(frozen=True)
class Mapped:
    """A scene whose pencil is solved over a map.

    Parameters
    ----------
    driver
        What solves the pencil.
    axes
        The axes.
    names
        Parameters of the pencil that each axis means, and the factor of each on its values: P of a
        contact has one where the axis is p.
    scene
        The scene as plain data, on which warnings depend too.
    max_frequency
        Upper end of the window (Hz).
    growth_threshold
        Growth rate (1/s) above which a mode is unstable; None where it is relative.
    min_growth
        Growth rate (1/s) down to which modes are sought where there is damping or rotation.
    warnings
        What modes must be read with at some parameters.
    """

    driver: EigenSolver
    axes: tuple[Varied, ...]
    names: tuple[Mapping[str, float], ...]
    scene: Mapping[str, Any]
    max_frequency: float
    growth_threshold: float | None
    min_growth: float | None = None
    warnings: Callable[[Modes, Mapping[str, float]], tuple[ResultWarning, ...]] = lambda modes, _: (
        modes.warnings
    )

    @property
    def pencil(self) -> Pencil:
        """The pencil."""
        return self.driver.pencil

    @property
    def box(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of every parameter that varies."""
        pairs = zip(self.axes, self.names, strict=True)
        return {
            name: (factor * axis.ends[0], factor * axis.ends[1])
            for axis, names in pairs
            for name, factor in names.items()
        }

    def point(self, values: Sequence[float]) -> dict[str, float]:
        """Parameters at a value of each axis."""
        pairs = zip(values, self.names, strict=True)
        return {name: factor * value for value, names in pairs for name, factor in names.items()}

    def rows(self) -> list[tuple[float, ...]]:
        """Values of all axes but the first, a row of the map each."""
        return list(product(*(axis.values for axis in self.axes[1:])))


def mapped(
    scene: str | Path, axes: Sequence[Varied], overrides: Sequence[str], data: str | None
) -> Mapped:
    """Assemble a scene; where a contact becomes too stiff for a penalty its forces are unknowns.

    Raises
    ------
    NoMapError
        When an axis is no parameter of the pencil, or the pencil is not that of all of the map;
        when it has no reduced model.
    InputError
        When the scene is refused, or a value of a parameter.
    """
    if is_of_matrices(scene):
        matrices = AssembledMatrices(load_matrices(scene, list(overrides), data))
        names = _names(matrices.driver.pencil, axes, {}, ())
        window = matrices.scene.window
        _check_definite(matrices.driver.pencil, axes, names, window.max_frequency)
        return Mapped(
            matrices.driver,
            tuple(axes),
            names,
            as_data(matrices.scene),
            window.max_frequency,
            window.growth_threshold,
            window.min_growth,
            lambda modes, _: matrices.warnings(modes),
        )
    if data is not None:
        raise InputError("data", data, "left out: a scene of bodies reads no matrices")
    read = load_scene(scene, list(overrides))
    first = AssembledScene(read)
    names = _names(first.driver.pencil, axes, read.contacts, first.bonded)
    moved = [name for each in names for name in each if first.depends_on_state([name])]
    if moved:
        first.free()
        allowed = "no parameter that moves a state of steady sliding"
        raise _no_map(InputError("axis", moved[0], allowed))
    stiffest = {
        name: factor * axis.ends[1 if name.endswith(".P") else 0]
        for axis, each in zip(axes, names, strict=True)
        for name, factor in each.items()
    }
    assembled = first.with_forms_at(stiffest)
    if assembled is not first:
        first.free()
    analysis = assembled.scene.analysis
    assert isinstance(analysis, ComplexEigenvalueAnalysis)
    _check_definite(assembled.driver.pencil, axes, names, analysis.max_frequency)
    return Mapped(
        assembled.driver,
        tuple(axes),
        names,
        as_data(assembled.scene),
        analysis.max_frequency,
        analysis.growth_threshold,
        analysis.min_growth,
        lambda modes, values: assembled.warnings(modes, analysis.max_frequency, values),
    )


def _names(
    pencil: Pencil,
    axes: Sequence[Varied],
    contacts: Mapping[str, ContactSpec],
    bonded: Sequence[str],
) -> tuple[Mapping[str, float], ...]:
    p = [stiffnesses_meant(contacts, axis.name) for axis in axes]
    names: tuple[Mapping[str, float], ...] = ()
    try:
        names = tuple(
            _of_p(pencil, own) or dict.fromkeys(parameters_meant(pencil, axis.name, bonded), 1.0)
            for axis, own in zip(axes, p, strict=True)
        )
        check_pencil(pencil, [name for each in names for name in each])
    except InputError as error:
        raise _no_map(error) from error
    no_two_alike(names, [axis.name for axis in axes])
    for axis, each in zip(axes, names, strict=True):
        for name, factor in each.items():
            for end in axis.ends:
                pencil.parameter(name).check(factor * end)
    return names


def _of_p(pencil: Pencil, p: Mapping[str, float]) -> dict[str, float]:
    """P of contacts and what it is for each unit of p, by the p that they have in the scene."""
    paths = {f"contacts.{contact}.P": own for contact, own in p.items()}
    return {path: pencil.parameter(path).value / own for path, own in paths.items()}


def _check_definite(
    pencil: Pencil,
    axes: Sequence[Varied],
    names: tuple[Mapping[str, float], ...],
    max_frequency: float,
) -> None:
    """Refuse a damped pencil whose stiffness makes no norm where parameters are least.

    That of bodies at rest does; with rotation or in matrices from elsewhere it may not.
    """
    if not pencil.damped:
        return
    least, most = (
        {
            name: factor * axis.ends[end]
            for axis, group in zip(axes, names, strict=True)
            for name, factor in group.items()
        }
        for end in (0, 1)
    )
    try:
        for each in (least, most):  # modes that are damped one by one may be others there
            pencil.check(each)
    except InputError as error:
        raise _no_map(error) from error
    matrices = pencil.at(least)
    try:
        negative = count_below(matrices, -shift_of(max_frequency))
    finally:
        release(matrices)
    if negative:
        told = f"{negative} negative eigenvalues of its symmetric part"
        allowed = "none, for a map, where parameters are least"
        raise _no_map(InputError("stiffness", told, allowed))


def _no_map(error: InputError) -> NoMapError:
    return NoMapError(error.field, error.value, error.allowed)
