"""A closed pipe is an error that Python raises: libraries that take its signal give it back."""

import signal
import threading


def ignore_closed_pipes() -> None:
    """Let a write to a closed pipe raise BrokenPipeError, as Python does.

    PETSc catches the signal that such a write sends, and gmsh leaves it to end the process without
    a word: a program that ends before it has read its input would take this one along. To be called
    after either begins. Signals belong to the main thread; elsewhere nothing changes, and nothing
    does on systems without the signal.
    """
    if hasattr(signal, "SIGPIPE") and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
