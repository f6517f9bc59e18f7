"""One contact on finer and finer meshes of both backends, stage by stage."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.bench.contact.cost import contact_cost
from comparisons.kit.progress import Progress
from scenes.results.record import record

COMMAND = "bench contact"
BACKENDS = ("fe", "iga")


@dataclass(frozen=True)
class ContactStudy:
    """What is measured.

    Parameters
    ----------
    elements
        Elements along each side of the upper block; 250 make a million Gauss points.
    repeats
        Measurements of each by turns; medians count.
    """

    elements: tuple[int, ...] = (40, 126, 250)
    repeats: int = 1

    def __post_init__(self) -> None:
        if not self.elements or min(self.elements) < 1:
            raise InputError("elements", self.elements, "one or more numbers, 1 or more each")
        if self.repeats < 1:
            raise InputError("repeats", self.repeats, "1 or more")


def run_contact(study: ContactStudy, progress: Progress) -> Iterator[dict[str, Any]]:
    """Measure every mesh on both backends.

    Yields
    ------
    dict
        The record as it grows: ``runs``, each with ``backend``, ``elements`` and ``costs``, a
        :class:`comparisons.bench.contact.cost.ContactCost` for each repeat.

    Raises
    ------
    InputError
        On several ranks.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("mpiexec", MPI.COMM_WORLD.size, "one rank: time is that of one")
    begun = perf_counter()
    runs: list[dict[str, Any]] = [
        {"backend": backend, "elements": count, "costs": []}
        for count in study.elements
        for backend in BACKENDS
    ]
    for number in range(study.repeats):
        for run in runs:
            backend, elements = run["backend"], run["elements"]
            progress.step(f"{backend}, {elements} elements a side, {number + 1} of {study.repeats}")
            run["costs"].append(asdict(contact_cost(backend, elements)))
            measured = {"runs": [each for each in runs if each["costs"]]}
            inputs = asdict(study) | {"elements": list(study.elements)}
            yield record(COMMAND, measured, inputs=inputs, seconds=perf_counter() - begun)
