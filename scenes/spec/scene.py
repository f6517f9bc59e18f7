"""What a scene says: frozen dataclasses, each of which refuses what is wrong with itself."""

from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from scenes.spec.analysis import Analysis
from scenes.spec.body import Backend, BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.load import LoadSpec

BACKENDS: tuple[Backend, ...] = ("fe", "iga")


@dataclass(frozen=True)
class OutputSpec:
    """What is made beside numbers.

    Parameters
    ----------
    pictures
        Modes to draw and animate, the most unstable first; with c_n what the contacts carry is
        drawn too, of a static analysis that alone.
    paraview
        Modes to write for ParaView, the most unstable first; of a static analysis, whether to
        write its displacement; with load steps those too.
    """

    pictures: Annotated[int, Field(ge=0)] = 0
    paraview: Annotated[int, Field(ge=0)] = 0


@dataclass(frozen=True)
class SceneSpec:
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
        supports = [each.support() for body in self.bodies.values() for each in body.supports]
        return any(support.prescribes for support in supports)


def on_backend[S: SceneSpec](scene: S, backend: Backend) -> S:
    """The scene with every body on one backend, not checked."""
    return replace(scene, bodies={n: replace(b, backend=backend) for n, b in scene.bodies.items()})


def with_contact[S: SceneSpec](scene: S, **changes: Any) -> S:
    """The scene with changed fields of every contact, not checked."""
    return replace(scene, contacts={n: replace(c, **changes) for n, c in scene.contacts.items()})
