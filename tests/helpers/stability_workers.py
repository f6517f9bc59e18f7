"""What judges runs in a worker's process: at once, or by ending the process."""

import os


def _judge(name, number):
    """Tell a run accurate; the second ends the process."""
    if number == 1:
        os._exit(5)
    return {
        "verdict": "accurate",
        "reason": "",
        "met": True,
        "error": 1e-12,
        "missing": 0,
        "spurious": 0,
        "residual": 1e-13,
        "condition": 1.0,
        "modes": 3,
        "growth": 0.0,
        "dofs": 8,
        "says": [],
        "seconds": 0.01,
    }


def dying():
    """Make what dies at the second run."""
    return _judge
