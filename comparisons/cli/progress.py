"""How far a command is: shown on a terminal, silent anywhere else."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from comparisons.cli.output import console


class Working:
    """Work that goes on.

    Parameters
    ----------
    shown
        Where it is shown.
    task
        Its line there.
    title
        What is done.
    """

    def __init__(self, shown: Progress, task: TaskID, title: str) -> None:
        self._shown, self._task, self._step = shown, task, title
        self._begun = False

    def stage(self, name: str) -> None:
        """Name what is being done within a step."""
        words = f"{self._step}: {name}" if self._step else name
        self._shown.update(self._task, description=words)

    def step(self, name: str) -> None:
        """Begin a step; the one before it, if any, is done."""
        if self._begun:
            self._shown.advance(self._task)
        self._begun, self._step = True, name
        self._shown.update(self._task, description=name)


class _SinceLastTime(ProgressColumn):
    """Time left if the work takes as long as it did last time."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._seconds = seconds

    def render(self, task: Task) -> Text:
        """Minutes and seconds."""
        left = round(self._seconds - (task.elapsed or 0.0))
        if left < 0:
            return Text("longer than last time")
        return Text(f"about {left // 60}:{left % 60:02d} left")


@contextmanager
def working(
    title: str,
    *,
    steps: int | None = None,
    expected: float | None = None,
    to: Console = console,
) -> Iterator[Working]:
    """Show how far a block of work is: time gone and, where something is known of it, time left.

    Parameters
    ----------
    title
        What is done.
    steps
        How many steps it has, which ``step`` begins; None where nobody knows.
    expected
        Seconds that it took last time, where steps are not known; None where nobody knows.
    to
        Where it is shown; nothing is where that is no terminal.
    """
    known: list[ProgressColumn] = []
    if steps is not None:
        known = [BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()]
    elif expected is not None:
        known = [_SinceLastTime(expected)]
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        *known,
        TimeElapsedColumn(),
        console=to,
        transient=True,
        disable=not to.is_terminal,
    ) as shown:
        yield Working(shown, shown.add_task(title, total=steps), "")
