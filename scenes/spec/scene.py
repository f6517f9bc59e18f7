"""What a scene says: frozen dataclasses, each of which refuses what is wrong with itself."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from scenes.spec.analysis import Analysis
from scenes.spec.body import BodySpec
from scenes.spec.contact import ContactSpec
from scenes.spec.load import LoadSpec


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
    """Bodies, contacts, loads and the analysis to be made of them, each right by itself.

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

    left_out: ClassVar[tuple[str, ...]] = ("units",)
    """Fields left out of plain data where they say nothing (:mod:`scenes.spec.plain`)."""

    # Nested dataclasses, those of other rooms too, are checked under the same configuration.
    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False
    )
