"""Error of flutter eigenvalues against run time: every discretisation with every formulation."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from comparisons.accuracy import errors, no_flutter
from comparisons.accuracy.cases import Options, lines
from comparisons.accuracy.page import SECTIONS
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study


def cases(options: Options) -> Iterator[Case]:
    """Cases of each part, labelled with it."""
    for part in options.parts:
        for case in lines(options) if part == "errors" else no_flutter.cases():
            yield {"part": part, **case}


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Tables of a case of its part."""
    part = errors if case["part"] == "errors" else no_flutter
    return part.evaluate(case, session)


STUDY = Study(
    name="accuracy",
    title="Error of flutter eigenvalues against run time",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    sections=SECTIONS,
    quick={
        "parts": ("errors",),
        "problems": ("blocks",),
        "stiffnesses": (1.0,),
        "most_dofs_2d": 2_000,
        "levels": 1,
        "repeats": 1,
    },
    process=Process("comparisons.accuracy.study:STUDY", 5 * errors.SECONDS),
    shipped=Path(__file__).parent / "results",
)
