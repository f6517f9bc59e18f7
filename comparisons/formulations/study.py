"""Tests of every contact formulation: patch tests, momentum, locking."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from comparisons.formulations import locking, patch_tests
from comparisons.study.study import Case, Session, Study
from scenes.spec.reading import Scene

PARTS: dict[str, Any] = {"patch_tests": patch_tests, "locking": locking}
"""Modules of the parts, which define ``cases`` and ``evaluate``."""


@dataclass(frozen=True)
class Options(patch_tests.Options, locking.Options):
    """Options of both parts."""

    parts: Annotated[tuple[str, ...], "Parts of the study."] = tuple(PARTS)


def cases(options: Options) -> Iterator[Case]:
    """Cases of all parts, labelled with the part."""
    for part in options.parts:
        for case in PARTS[part].cases(options):
            yield {"part": part, **case}


def scene(case: Case, options: Options) -> Scene | None:
    """Return the scene of a case of locking; cases of patch tests have several."""
    return locking.scene(case, options) if case["part"] == "locking" else None


def evaluate(case: Case, session: Session) -> Any:
    """Evaluate a case by its part."""
    return PARTS[case["part"]].evaluate(case, session)


STUDY = Study(
    name="formulations",
    title="Contact formulations",
    options=Options,
    cases=cases,
    scene=scene,
    evaluate=evaluate,
    quick={
        "P": (1e6, 1e14),
        "gauss": (5,),
        "samples": 9,
        "interfaces": ("flat",),
        "meshes": ("NURBS",),
        "formulations": ("Greville", "GPTS 5", "GPTS 5, lumped", "segments", "mortar"),
        "p": (1.0, 1e6),
        "elements_a": (6, 2),
        "elements_b": (7, 3),
    },
    sections=[*patch_tests.SECTIONS, locking.SECTION],
)
