"""Variants of every contact formulation, as changes of a scene's contacts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from cea.contact.formulations import (
    Botella,
    Form,
    Formulation,
    GaussPointToSurface,
    Greville,
    Grid,
    Mortar,
    NodeToSurface,
    Segments,
)
from scenes.spec.body import Backend
from scenes.spec.contact import suits
from scenes.spec.reading import Scene


@dataclass(frozen=True)
class Variant:
    """A formulation with its options; in a full pass points lie on both sides."""

    formulation: Formulation
    full_pass: bool = False

    @property
    def label(self) -> str:
        """Name in tables and figures: the formulation, then its options behind commas."""
        rule = self.formulation
        name = f"{rule.name} {rule.points}" if isinstance(rule, GaussPointToSurface) else rule.name
        return ", ".join((name, *rule.options, *(["full pass"] if self.full_pass else [])))

    def of(self, scene: Scene, *, P: float | None = None, p: float | None = None) -> Scene:
        """The scene with this variant and P or p at every contact; saddle form if infinite."""
        form: Form = "saddle" if inf in (P, p) else "penalty"
        contacts = {
            name: replace(
                contact,
                formulation=self.formulation,
                full_pass=self.full_pass,
                P=P,
                p=p,
                form=form,
            )
            for name, contact in scene.contacts.items()
        }
        return replace(scene, contacts=contacts)


def variants(
    backends: tuple[Backend, Backend], gauss: tuple[int, ...], grid: int, only: Sequence[str] = ()
) -> dict[str, Variant]:
    """Formulations by label that the backends of sides a and b allow, or those in ``only``.

    ``gauss`` are numbers of Gauss points per direction in each cell of side a, ``grid`` the number
    of equally spaced points per direction on a face (NURBS) or on a facet (mesh).
    """
    a, b = backends
    collocation = (
        NodeToSurface(),
        NodeToSurface("tributary"),
        Greville(),
        Greville("area"),
        Botella(),
        Botella("area"),
    )
    own = [Variant(rule) for rule in collocation if suits(rule, a)]
    gpts = [Variant(GaussPointToSurface(n)) for n in gauss]
    lumped = [Variant(GaussPointToSurface(n, lumped=True)) for n in gauss]
    # A full pass of collocation at the sides' own abscissae needs one backend on both sides.
    both_ways = [own[0], gpts[0]] if a == b else [gpts[0]]
    full = [replace(variant, full_pass=True) for variant in both_ways]
    yardsticks = [Variant(Segments()), Variant(Mortar())]
    every = [*own, Variant(Grid(grid)), *gpts, *lumped, *full, *yardsticks]
    return {v.label: v for v in every if not only or v.label in only}
