"""Bad input for everything that reads: scenes, paths of `--set`, files, meshes, expressions."""

import signal
from contextlib import contextmanager
from time import perf_counter

from cea.errors import ConvergenceError, InputError
from scenes.spec.problems import SceneError

PATIENCE = 20.0
"""Seconds after which an input hangs; each takes milliseconds on a machine with nothing else."""
REFUSALS = (InputError, SceneError, ConvergenceError)
"""Values that a setting may be given."""


@contextmanager
def patience(seconds=PATIENCE):
    """Stop what hangs; a TimeoutError is no refusal."""

    def ring(*_):
        raise TimeoutError("hangs")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def faults_of(error):
    """The faults that a refusal tells."""
    return error.faults if isinstance(error, SceneError) else (error,)


def complaint(bad, read):
    """What is wrong with how an input was met, in words; None where all is well.

    A refusal is told in short lines that name a field. Anything else raised is a crash.
    """
    start = perf_counter()
    try:
        with patience():
            read(bad.value)
    except REFUSALS as error:
        lines = str(error).splitlines()
        if isinstance(error, InputError | SceneError):
            faults = faults_of(error)
            if not faults or not all(fault.field and fault.allowed for fault in faults):
                return f"{bad.words}: refused without a name: {error}"
            if bad.refused and bad.place and not _near(bad.place, faults):
                return f"{bad.words}: refused under another name: {lines[0]}"
            if len(lines) > 21 or max(map(len, lines)) > 2500:
                return f"{bad.words}: a refusal of {len(str(error))} characters"
        return None
    except Exception as error:
        return f"{bad.words}: {type(error).__name__}: {str(error)[:200]}"
    if bad.refused:
        return f"{bad.words}: accepted in {perf_counter() - start:.2f} s"
    return None


def _near(place, faults):
    """Whether some fault is told under the section that is wrong, or one of its own."""
    section = ".".join(map(str, place[:2]))
    return any(f.field.startswith((section, str(place[0]))) for f in faults)
