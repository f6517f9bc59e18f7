"""Error of flutter eigenvalues against run time: every discretisation with every formulation."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from comparisons.accuracy import errors, limits
from comparisons.accuracy.cases import PARTS, Options, lines
from comparisons.accuracy.page import SECTIONS
from comparisons.study.session import Session
from comparisons.study.study import Case, Process, Study


def cases(options: Options) -> Iterator[Case]:
    """Cases of each part, labelled with it."""
    made: dict[str, Iterable[Case]] = dict(
        zip(PARTS, (lines(options), limits.no_flutter_cases(), limits.finest_cases()), strict=True)
    )
    for part in options.parts:
        for case in made[part]:
            yield {"part": part, **case}


def evaluate(case: Case, session: Session) -> dict[str, list[dict[str, Any]]]:
    """Tables of a case of its part."""
    part = dict(zip(PARTS, (errors.evaluate, limits.growth, limits.digits), strict=True))
    return part[case["part"]](case, session)


STUDY = Study(
    name="accuracy",
    title="Error of flutter eigenvalues against run time",
    options=Options,
    cases=cases,
    evaluate=evaluate,
    sections=SECTIONS,
    quick={
        "parts": ("errors",),
        "problems": ("drum", "blocks"),
        "thorough": False,
        "most_dofs_2d": 4_500,
        "levels": 2,
        "repeats": 1,
    },
    process=Process("comparisons.accuracy.study:STUDY", 5 * errors.SECONDS),
    shipped=Path(__file__).parent / "results",
)
