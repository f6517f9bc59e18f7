"""Every contact formulation put to the test: what the page of formulations is made of."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from time import perf_counter
from typing import Any

from comparisons.formulations.locking import LockingStudy, run_locking
from comparisons.formulations.pairings import PairingsStudy, run_pairings
from comparisons.formulations.patch_tests import PatchTestStudy, run_patch_tests
from comparisons.kit.progress import Progress
from scenes.stored import record

COMMAND = "formulations"
"""Command that a result is marked with."""


@dataclass(frozen=True)
class FormulationsStudy:
    """What is run.

    Parameters
    ----------
    patch_tests, locking, pairings
        The studies.
    """

    patch_tests: PatchTestStudy = field(default_factory=PatchTestStudy)
    locking: LockingStudy = field(default_factory=LockingStudy)
    pairings: PairingsStudy = field(default_factory=PairingsStudy)


DEFAULT = FormulationsStudy()


def run_formulations(
    progress: Progress,
    begin: Callable[[str], None],
    paper_numbers: Callable[[Progress], dict[str, Any]],
    study: FormulationsStudy = DEFAULT,
) -> dict[str, Any]:
    """Run all studies.

    Parameters
    ----------
    progress
        Where progress within a part is shown.
    begin
        Called with the name of each part as it begins.
    paper_numbers
        Computes the numbers of the paper that the page shows beside ours; a function of the
        application of the paper, which this one does not know.
    study
        What is run.

    Returns
    -------
    dict
        Record with the parts ``patch_tests``, ``locking``, ``paper`` and ``pairings``, each with
        its ``seconds``.
    """
    parts: dict[str, tuple[str, Callable[[], dict[str, Any]]]] = {
        "patch_tests": (
            "patch tests and momentum",
            lambda: run_patch_tests(progress, study.patch_tests),
        ),
        "locking": ("locking", lambda: run_locking(progress, study.locking)),
        "paper": ("numbers of the paper", lambda: paper_numbers(progress)),
        "pairings": (
            "pairings of backends",
            lambda: run_pairings(progress, study.pairings),
        ),
    }
    begun = perf_counter()
    data: dict[str, Any] = {}
    for key, (name, run) in parts.items():
        begin(name)
        start = perf_counter()
        data[key] = run()
        data[key]["seconds"] = perf_counter() - start
    return record(COMMAND, data, inputs=asdict(study), seconds=perf_counter() - begun)
