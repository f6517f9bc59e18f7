"""Scenes of bodies: read from files or plain data, and validated before any computation.

A scene consists of frozen dataclasses, each of which validates its own fields.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from cea.errors import InputError, require
from scenes.spec.body import Backend, BodySpec, LoadSpec
from scenes.spec.consistency import consistent
from scenes.spec.contact import ContactSpec
from scenes.spec.plain import changed, checked, scene_file, tables_of
from scenes.spec.problems import refuse

MAX_STEPS = 1000
"""Largest number of load steps."""

LoadSteps = Annotated[int, Field(ge=1, le=MAX_STEPS)] | tuple[float, ...]
"""Number of equal load steps, or the load factor at the end of each step."""


def _check_load_steps(steps: LoadSteps | None) -> None:
    if isinstance(steps, tuple):
        rising = all(a < b for a, b in pairwise((0.0, *steps))) and steps[-1:] == (1,)
        allowed = f"at most {MAX_STEPS} load factors that increase from above 0 to 1"
        require(rising and len(steps) <= MAX_STEPS, "load_steps", list(steps), allowed)


@dataclass(frozen=True)
class StaticAnalysis:
    """Static displacements under the loads; reports normal stresses of the contacts.

    Parameters
    ----------
    samples
        Points along each side of a contact at which its normal stress is reported.
    load_steps
        With c_n, number of equal steps in which loads and prescribed displacements are applied, or
        the load factors at the end of each step, increasing to 1.
    """

    kind: Literal["static"]
    samples: Annotated[int, Field(ge=2, le=1000)] = 91
    load_steps: LoadSteps | None = None

    def __post_init__(self) -> None:
        _check_load_steps(self.load_steps)


@dataclass(frozen=True)
class ComplexEigenvalueAnalysis:
    """Complex eigenvalue analysis: all modes up to a frequency.

    Parameters
    ----------
    max_frequency
        Upper end of the window (Hz).
    growth_threshold
        Growth rate (1/s) above which a mode is reported as unstable; by default 1e-4 abs(lambda).
    min_growth
        With damping or rotation, lowest growth rate (1/s) of the window, zero or less; by default
        minus a tenth of the angular frequency of its upper end.
    load_steps
        Number of equal steps in which loads and prescribed displacements are applied, or the load
        factors at the end of each step, increasing to 1. The result keeps the equilibrium of every
        step. By default they are applied in one step.
    geometric_stiffness
        Whether to add the geometric stiffness of the stresses of steady sliding, and the stiffness
        of pressures in loads, which follow their surface as it turns and stretches. Forces keep
        their direction and size; so do contact pressures and friction, with a warning.
    """

    kind: Literal["cea"]
    max_frequency: Annotated[float, Field(gt=0)]
    growth_threshold: Annotated[float, Field(ge=0)] | None = None
    min_growth: Annotated[float, Field(le=0)] | None = None
    load_steps: LoadSteps | None = None
    geometric_stiffness: bool = False

    def __post_init__(self) -> None:
        _check_load_steps(self.load_steps)


Analysis = StaticAnalysis | ComplexEigenvalueAnalysis

BACKENDS: tuple[Backend, ...] = ("fe", "iga")


@dataclass(frozen=True)
class OutputSpec:
    """Pictures and ParaView files to write.

    Parameters
    ----------
    pictures
        Number of modes to draw, the most unstable first. With c_n, contact pressures are drawn too;
        in a static analysis only these.
    paraview
        Number of modes to write for ParaView, the most unstable first; in a static analysis, 1 to
        write the displacement. With load steps, all of them are written too.
    """

    pictures: Annotated[int, Field(ge=0)] = 0
    paraview: Annotated[int, Field(ge=0)] = 0


@dataclass(frozen=True)
class Scene:
    """Bodies, contacts, loads and the analysis of their coupled system.

    Parameters
    ----------
    name
        Name of the scene.
    bodies
        Bodies by name; names contain no dots, commas, brackets or blanks.
    analysis
        Analysis to run: modes, or static displacements under the loads.
    contacts
        Contacts between surfaces of two bodies, by name.
    loads
        Pressures and forces.
    output
        Pictures and ParaView files to write.
    description
        Free text.
    units
        "other" for consistent units other than SI, or dimensionless numbers; warnings about values
        that are implausible in SI units are then omitted, and lengths of files taken as they are.
    """

    name: str
    bodies: dict[str, BodySpec]
    analysis: Annotated[Analysis, Field(discriminator="kind")]
    contacts: dict[str, ContactSpec] = field(default_factory=dict)
    loads: tuple[LoadSpec, ...] = ()
    output: OutputSpec = field(default_factory=OutputSpec)
    description: str = ""
    units: Literal["SI", "other"] = "SI"

    # The configuration also applies to nested dataclasses, including those of other packages.
    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False
    )

    @property
    def backends(self) -> str:
        """Backends of the bodies: "fe", "iga" or "fe+iga"."""
        return "+".join(sorted({body.backend for body in self.bodies.values()}))

    @property
    def window(self) -> ComplexEigenvalueAnalysis:
        """Window of the modes to compute; raises an InputError for a static analysis."""
        if not isinstance(self.analysis, ComplexEigenvalueAnalysis):
            raise InputError("analysis.kind", self.analysis.kind, "'cea', which gives modes")
        return self.analysis

    @property
    def damped(self) -> bool:
        """Whether there are terms in the velocities: damping of bodies or sliding contacts."""
        damping = [body.damping for body in self.bodies.values() if body.damping is not None]
        sliding = [contact.sliding for contact in self.contacts.values()]
        return any(each.acts for each in damping) or any(sliding)

    @property
    def rotates(self) -> bool:
        """Whether a body rotates."""
        return any(body.rotation is not None for body in self.bodies.values())

    @property
    def slides_steadily(self) -> bool:
        """Whether a state of steady sliding is computed: a contact has a normal compliance."""
        return any(contact.c_n is not None for contact in self.contacts.values())

    @property
    def has_friction(self) -> bool:
        """Whether a contact has friction."""
        return any(contact.mu for contact in self.contacts.values())

    @property
    def stiffened_by_stress(self) -> bool:
        """Whether the geometric stiffness of the stresses of steady sliding is added."""
        return self.analysis.kind == "cea" and self.analysis.geometric_stiffness

    @property
    def has_turning_pressure(self) -> bool:
        """Whether stiffness of pressures is added, which may be unsymmetric without friction."""
        return self.stiffened_by_stress and any(load.pressure is not None for load in self.loads)

    @property
    def prescribes(self) -> bool:
        """Whether a support prescribes a nonzero displacement."""
        supports = (each for body in self.bodies.values() for each in body.supports)
        return any(support.prescribes for support in supports)

    def change(self, field: str | Mapping[str, Any], value: Any = None) -> "Scene":
        """Return the scene with fields changed, validated like a file.

        Parameters
        ----------
        field
            Path of a field, e.g. "contacts.pad_disc.mu"; or a mapping of paths to values.
        value
            New value of a single field: plain data as in a file, or a section, e.g. a formulation.

        Raises
        ------
        SceneError
            With one line for each fault.
        """
        return read_scene(changed(self, field, value))

    def on(self, backend: Backend) -> "Scene":
        """Return the scene with every body on one backend.

        Raises
        ------
        SceneError
            If a body has no mesh for the backend, or the backend lacks a formulation.
        """
        return self.change({f"bodies.{name}.backend": backend for name in self.bodies})


def load_scene(
    scene: str | Path, overrides: Iterable[str] = (), backend: Backend | None = None
) -> Scene:
    """Read a scene.

    Parameters
    ----------
    scene
        Name of a scene that comes with the project, or path of a TOML file. A path ends in
        ``.toml`` or contains a separator.
    overrides
        Fields to set, each as "path.to.field=value" with a TOML value.
    backend
        Backend of every body; by default those of the scene.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    data = tables_of(scene, overrides)
    if "files" in data and "bodies" not in data:
        refuse("scene", str(scene), "a scene of bodies; one of matrices is read by load_matrices")
    bodies = data.get("bodies")
    for body in bodies.values() if isinstance(bodies, dict) else ():
        if isinstance(body, dict):
            if backend is not None:
                body["backend"] = backend
            geometry = body.get("geometry")
            if isinstance(geometry, dict) and isinstance(geometry.get("file"), str):
                geometry["file"] = str(scene_file(scene).parent / geometry["file"])
    return read_scene(data)


def read_scene(data: Mapping[str, Any]) -> Scene:
    """Check a scene given as nested dictionaries and return a :class:`Scene`.

    Raises
    ------
    SceneError
        With one line for each fault. Fields are checked against each other only if each is valid.
    """
    return consistent(checked(Scene, data))
