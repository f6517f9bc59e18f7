"""Scenes: what they say, read from files or plain data, and refused when wrong before work begins.

A scene is made of frozen dataclasses, each of which refuses what is wrong with itself.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, TypeAdapter

from cea.contact.formulations import Formulation, registered
from cea.errors import InputError, require
from scenes.spec.body import Backend, BodySpec, LoadSpec
from scenes.spec.consistency import consistent
from scenes.spec.contact import ContactSpec
from scenes.spec.plain import changed, checked, scene_file, tables_of
from scenes.spec.problems import SceneError

MAX_STEPS = 1000
"""Steps in which a load is put on."""

LoadSteps = Annotated[int, Field(ge=1, le=MAX_STEPS)] | tuple[float, ...]
"""A number of equal steps, or the part of the load at the end of each."""


def _check_load_steps(steps: LoadSteps | None) -> None:
    if isinstance(steps, tuple):
        rising = all(a < b for a, b in pairwise((0.0, *steps))) and steps[-1:] == (1,)
        allowed = f"at most {MAX_STEPS} parts of the load that rise from above 0 to 1"
        require(rising and len(steps) <= MAX_STEPS, "load_steps", list(steps), allowed)


@dataclass(frozen=True)
class StaticAnalysis:
    """Displacements under the loads; reports stresses over the contacts.

    Parameters
    ----------
    samples
        Points along each side of a contact at which its normal stress is reported.
    load_steps
        With c_n, number of equal steps in which loads and prescribed displacements are put on; or
        the part of them at the end of each step, rising to 1.
    """

    kind: Literal["static"]
    samples: Annotated[int, Field(ge=2, le=1000)] = 91
    load_steps: LoadSteps | None = None

    def __post_init__(self) -> None:
        _check_load_steps(self.load_steps)


@dataclass(frozen=True)
class ComplexEigenvalueAnalysis:
    """All modes up to a frequency.

    Parameters
    ----------
    max_frequency
        Upper end of the window (Hz).
    growth_threshold
        Growth rate above which a mode is called unstable (1/s); by default 1e-4 of abs(lambda).
    min_growth
        With damping or rotation, growth rate (1/s), zero or less, down to which modes are sought;
        by default a tenth of the angular frequency of the upper end.
    load_steps
        Number of equal steps in which loads, and displacements that supports prescribe, are put
        on; or the part of them at the end of each step, rising to 1. The result keeps the
        equilibrium at every step. Left out, they are put on at once.
    geometric_stiffness
        Whether the stresses of steady sliding stiffen, or soften, small motions.
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
    """What is made beside numbers.

    Parameters
    ----------
    pictures
        Modes to draw, the most unstable first; with c_n what the contacts carry is
        drawn too, of a static analysis that alone.
    paraview
        Modes to write for ParaView, the most unstable first; of a static analysis, whether to
        write its displacement; with load steps those too.
    """

    pictures: Annotated[int, Field(ge=0)] = 0
    paraview: Annotated[int, Field(ge=0)] = 0


@dataclass(frozen=True)
class Scene:
    """Bodies, contacts, loads and the analysis to be made of them.

    Parameters
    ----------
    name
        Its name.
    bodies
        Bodies by name; names hold no dots, commas, brackets or blanks.
    analysis
        What is sought: modes, or the displacement under the loads.
    contacts
        Contacts between surfaces of two bodies, by name.
    loads
        Pressures and forces.
    output
        What is made beside numbers.
    description
        In words.
    units
        "other" where numbers are in consistent units that are not SI, or in none; they are then not
        compared with those of solids in SI units.
    """

    name: str
    bodies: dict[str, BodySpec]
    analysis: Annotated[Analysis, Field(discriminator="kind")]
    contacts: dict[str, ContactSpec] = field(default_factory=dict)
    loads: tuple[LoadSpec, ...] = ()
    output: OutputSpec = field(default_factory=OutputSpec)
    description: str = ""
    units: Literal["SI", "other"] = "SI"

    # Nested dataclasses, those of other rooms too, are checked under the same configuration.
    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False
    )

    @property
    def backends(self) -> str:
        """Backends of its bodies: "fe", "iga" or "fe+iga"."""
        return "+".join(sorted({body.backend for body in self.bodies.values()}))

    @property
    def window(self) -> ComplexEigenvalueAnalysis:
        """The modes that are wanted; an InputError where the analysis gives none."""
        if not isinstance(self.analysis, ComplexEigenvalueAnalysis):
            raise InputError("analysis.kind", self.analysis.kind, "'cea', which gives modes")
        return self.analysis

    @property
    def damped(self) -> bool:
        """Whether anything damps, or feeds, small velocities."""
        damping = [body.damping for body in self.bodies.values() if body.damping is not None]
        sliding = [contact.sliding for contact in self.contacts.values()]
        return any(each.acts for each in damping) or any(sliding)

    @property
    def rotates(self) -> bool:
        """Whether a body rotates."""
        return any(body.rotation is not None for body in self.bodies.values())

    @property
    def slides_steadily(self) -> bool:
        """Whether a state of steady sliding is sought: a contact has a law of its closure."""
        return any(contact.c_n is not None for contact in self.contacts.values())

    @property
    def has_friction(self) -> bool:
        """Whether a contact has friction."""
        return any(contact.mu for contact in self.contacts.values())

    @property
    def stiffened_by_stress(self) -> bool:
        """Whether the stresses of steady sliding stiffen, or soften, small motions."""
        return self.analysis.kind == "cea" and self.analysis.geometric_stiffness

    @property
    def prescribes(self) -> bool:
        """Whether a support holds anything elsewhere than at zero."""
        supports = (each for body in self.bodies.values() for each in body.supports)
        return any(support.prescribes for support in supports)

    def change(self, field: str | Mapping[str, Any], value: Any = None) -> "Scene":
        """The scene with fields changed, checked anew as a file is.

        Parameters
        ----------
        field
            Path of a field, e.g. "contacts.pad_disc.mu"; or values of several by their paths.
        value
            Value of the one field: plain data as in a file, or a section such as a formulation.

        Raises
        ------
        SceneError
            With one line for each fault.
        """
        return read_scene(changed(self, field, value))

    def on(self, backend: Backend) -> "Scene":
        """The scene with every body on one backend.

        Raises
        ------
        SceneError
            When a body has no mesh there, or a formulation does not suit it.
        """
        return self.change({f"bodies.{name}.backend": backend for name in self.bodies})


def with_contact(scene: Scene, **changes: Any) -> Scene:
    """The scene with changed fields of every contact, not checked."""
    return replace(scene, contacts={n: replace(c, **changes) for n, c in scene.contacts.items()})


def load_scene(
    scene: str | Path, overrides: Iterable[str] = (), backend: Backend | None = None
) -> Scene:
    """Read a scene.

    Parameters
    ----------
    scene
        Name of a scene that comes with the project; or a TOML file, which is told by its ending
        or by a separator in its path.
    overrides
        Fields to set, each as "path.to.field=value" with a TOML value.
    backend
        Backend for every body; None leaves what the scene says.

    Raises
    ------
    SceneError
        With one line for each fault.
    """
    data = tables_of(scene, overrides)
    if "files" in data and "bodies" not in data:
        allowed = "a scene of bodies; one of matrices is read by load_matrices"
        raise SceneError([InputError("scene", str(scene), allowed)])
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
    """Check a scene given as nested dictionaries and make it a :class:`Scene`.

    Raises
    ------
    SceneError
        With one line for each fault: those of single fields, and when these are right those
        between fields.
    """
    return consistent(checked(_adapter(tuple(registered().values())), data))


@cache
def _adapter(formulations: tuple[type[Formulation], ...]) -> TypeAdapter[Scene]:
    return TypeAdapter(Scene)
