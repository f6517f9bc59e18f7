"""All that the doctor looks at, in order: each finding as soon as it is known."""

from collections.abc import Iterator

from comparisons.doctor.finding import Finding
from comparisons.doctor.packages import packages, python
from comparisons.doctor.system import compiler, launcher, libraries, memory, python_header


def examine(*, launched: bool) -> Iterator[Finding]:
    """Look at everything.

    Parameters
    ----------
    launched
        Whether a launcher of MPI began this process.

    Yields
    ------
    Finding
        What was found, cheap things first.
    """
    yield python()
    installed = list(packages())
    yield from installed
    yield compiler()
    yield python_header()
    yield from libraries()
    if not all(finding.well for finding in installed):
        return  # what follows would fail for what is told already
    yield launcher(launched=launched)  # before MPI begins here: no launcher starts inside of it
    from comparisons.doctor.solves import mpi, solve

    yield mpi()
    yield memory()
    yield solve("fe")
    yield solve("iga")
