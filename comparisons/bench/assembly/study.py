"""Stiffness and mass of one body by several programs: processor time, memory, and what they give.

Every program runs in a process of its own on one thread. Those that assemble the same
discretisation take turns, and plain dolfinx with quadratic hexahedra takes a turn in each round:
what else the machine does then slows all of them alike, and ratios to it stay what they are.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any

from cea.errors import InputError
from cea.petsc import MPI
from comparisons.bench.annulus import Boxes, Discretisation
from comparisons.bench.assembly.catalogue import (
    ENTRANTS,
    PLAIN,
    YARDSTICK,
    Entrant,
    discretisations,
    entrant,
)
from comparisons.bench.assembly.programs.measured import answers
from comparisons.kit.progress import Progress
from comparisons.kit.worker import Worker, WorkerError
from scenes.results.record import record

COMMAND = "bench assembly"
Ask = Callable[..., dict[str, Any]]
"""Asks a program a question in its process."""
_TINY: Boxes = (1, 1, 1)
"""A body on which a program is run once ahead of all, to load and compile what it needs."""


@dataclass(frozen=True)
class AssemblyStudy:
    """What is run.

    Parameters
    ----------
    only
        Names of discretisations, as ``Q2``; all without any.
    programs
        Names of programs; all that are installed without any.
    boxes
        Elements along radius, angle and height.
    boxes_of_degree_4
        Those of Lagrange functions of degree 4.
    checked_boxes
        Those on which eigenvalues are compared.
    modes
        Eigenvalues that are compared.
    repeats
        Rounds; medians count.
    seconds
        Longest time for one assembly; what takes longer is left out.
    """

    only: tuple[str, ...] = ()
    programs: tuple[str, ...] = ()
    boxes: Boxes = (16, 16, 8)
    boxes_of_degree_4: Boxes = (8, 8, 4)
    checked_boxes: Boxes = (4, 4, 2)
    modes: int = 6
    repeats: int = 3
    seconds: float = 120.0

    def __post_init__(self) -> None:
        if self.repeats < 1:
            raise InputError("repeats", self.repeats, "1 or more")
        if self.modes < 1:
            raise InputError("modes", self.modes, "1 or more")
        names = [each.name for each in ENTRANTS]
        for name in self.programs:
            if name not in names:
                raise InputError("programs", name, f"one of {', '.join(names)}")
        discretisations(self.only, self.boxes, self.boxes_of_degree_4)

    @property
    def entrants(self) -> list[Entrant]:
        """Programs that take part."""
        return [each for each in ENTRANTS if not self.programs or each.name in self.programs]


def run_assembly(study: AssemblyStudy, progress: Progress) -> Iterator[dict[str, Any]]:
    """Run every program on every discretisation it knows.

    Yields
    ------
    dict
        The record so far after each discretisation, so that what was measured outlives a study
        that is cut short: ``runs``, each with what was assembled, by what ``program``, ``dofs``
        and ``elements``, processor seconds of ``stiffness`` and ``mass`` and those of an element
        of the ``yardstick`` in each round, ``peak`` and ``finished`` memory (bytes), ``check``,
        and ``failed``, the reason or ""; ``left_out``, programs that are not installed.

    Raises
    ------
    InputError
        On several ranks.
    """
    if MPI.COMM_WORLD.size > 1:
        raise InputError("ranks", MPI.COMM_WORLD.size, "1: every program runs on one")
    begun, runs = perf_counter(), list[dict[str, Any]]()
    missing = [each for each in study.entrants if not each.installed]
    left_out = [{"program": each.name, "needs": each.needs} for each in missing]
    inputs = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(study).items()}
    for discretisation in discretisations(study.only, study.boxes, study.boxes_of_degree_4):
        progress.step(discretisation.name)
        runs += _of_one(study, discretisation, progress)
        data = {"runs": list(runs), "left_out": left_out}
        yield record(COMMAND, data, inputs=inputs, seconds=perf_counter() - begun)


def _of_one(
    study: AssemblyStudy, discretisation: Discretisation, progress: Progress
) -> Iterator[dict[str, Any]]:
    """All programs on one discretisation, by turns."""
    taking_part = [e for e in study.entrants if e.installed and e.knows(discretisation)]
    tiny = Discretisation(discretisation.family, discretisation.degree, _TINY)
    unit = Discretisation(*YARDSTICK, study.boxes)
    with ExitStack() as stack:
        asked = {each.name: _process(stack, each, study.seconds) for each in taking_part}
        yardstick = _process(stack, entrant(PLAIN), study.seconds)
        yardstick("time", Discretisation(*YARDSTICK, _TINY))
        turns: dict[str, list[dict[str, Any]]] = {name: [] for name in asked}
        failed: dict[str, str] = {}
        units = []
        for number in range(study.repeats):
            units.append(_sum(yardstick("time", unit)) / unit.elements)
            for name, ask in asked.items():
                if name in failed:
                    continue
                progress.stage(f"{name}, {number + 1} of {study.repeats}")
                try:
                    if number == 0:
                        ask("time", tiny)
                    turns[name].append(ask("time", discretisation))
                except WorkerError as error:
                    failed[name] = str(error)
        coarse = Discretisation(discretisation.family, discretisation.degree, study.checked_boxes)
        for name, ask in asked.items():
            check: dict[str, Any] = {}
            if name not in failed:
                progress.stage(f"{name}, what it gives")
                try:
                    check = ask("check", coarse, study.modes)
                except WorkerError as error:
                    failed[name] = str(error)
            yield _described(discretisation, name, turns[name], units, check, failed.get(name, ""))


def _process(stack: ExitStack, each: Entrant, seconds: float) -> Ask:
    """A process of a program, ended with the stack."""
    worker = Worker(answers)
    stack.callback(worker.end)

    def ask(question: str, discretisation: Discretisation, *arguments: Any) -> dict[str, Any]:
        found: dict[str, Any] = worker.ask(
            question, each.path, discretisation, *arguments, seconds=seconds
        )
        return found

    return ask


def _sum(turn: Mapping[str, Any]) -> float:
    """Processor seconds of both matrices."""
    return turn["stiffness"] + turn["mass"]


def _described(
    discretisation: Discretisation,
    program: str,
    turns: list[dict[str, Any]],
    units: list[float],
    check: dict[str, Any],
    failed: str,
) -> dict[str, Any]:
    """A program on a discretisation, plain data."""
    return {
        "discretisation": discretisation.name,
        "family": discretisation.family,
        "degree": discretisation.degree,
        "boxes": list(discretisation.boxes),
        "elements": discretisation.elements,
        "program": program,
        "dofs": int(turns[0]["dofs"]) if turns else None,
        "stiffness": [turn["stiffness"] for turn in turns],
        "mass": [turn["mass"] for turn in turns],
        "clock": [turn["clock"] for turn in turns],
        "yardstick": units[: len(turns)],
        "peak": turns[0]["peak"] if turns else None,
        "finished": turns[0]["finished"] if turns else None,
        "check": check,
        "failed": failed,
    }
