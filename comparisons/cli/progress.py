"""How far a command is: shown on a terminal, silent anywhere else."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from comparisons.cli.output import console


class Working:
    """Work that goes on, a line of what is shown."""

    def __init__(self, shown: Progress, task: TaskID) -> None:
        self._shown, self._task, self._step = shown, task, ""

    def stage(self, name: str) -> None:
        """Name what is being done within a step."""
        words = f"{self._step}: {name}" if self._step else name
        self._shown.update(self._task, description=words)

    def step(self, name: str) -> None:
        """Begin a step; the one before it, if any, is done."""
        if self._step:
            self._shown.advance(self._task)
        self._step = name
        self._shown.update(self._task, description=name)


@contextmanager
def working(title: str, *, steps: int | None = None, to: Console = console) -> Iterator[Working]:
    """Show how far a block of work is: time gone and, where its steps are known, time left."""
    known = [] if steps is None else [BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()]
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        *known,
        TimeElapsedColumn(),
        console=to,
        transient=True,
        disable=not to.is_terminal,
    ) as shown:
        yield Working(shown, shown.add_task(title, total=steps))
