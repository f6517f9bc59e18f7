"""Programs on any number of ranks, started in one way by the tests of every room.

`on_ranks` calls a function of a module of this folder on every rank of a new MPI program and
returns what it returned on rank 0; equal calls are made once in a session. `mpiexec` starts any
other command.
"""

import json
import os
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

HELPERS = Path(__file__).parent
BIN = Path(sys.executable).parent
TIMEOUT = 600
"""Seconds after which a program hangs."""
# Ranks that wait sleep a little: there may be fewer cores than ranks, and other work on them.
ENVIRONMENT = os.environ | {
    "OMP_NUM_THREADS": "1",
    "MPIR_CVAR_POLLS_BEFORE_YIELD": "1",
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE": "1",
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT": "100",
    "PYTHONPATH": os.pathsep.join((str(HELPERS.parents[1]), str(HELPERS))),
}


def run(*command):
    """A command in the environment of all of them, its output kept."""
    return subprocess.run(
        command, capture_output=True, text=True, env=ENVIRONMENT, timeout=TIMEOUT, check=False
    )


def mpiexec(ranks, *command):
    """A command on so many ranks, its output kept."""
    return run(BIN / "mpiexec", "-n", str(ranks), *command)


@cache
def on_ranks(ranks, function, *arguments):
    """What a function, "module.name", returns on rank 0 of so many ranks.

    Arguments and result are plain data, ready for JSON. The result is shared: leave it as it is.
    """
    done = mpiexec(ranks, sys.executable, __file__, function, json.dumps(arguments))
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout)


def _call():
    from cea.petsc import MPI

    module, name = sys.argv[1].split(".")
    result = getattr(import_module(module), name)(*json.loads(sys.argv[2]))
    if MPI.COMM_WORLD.rank == 0:
        sys.stdout.write(json.dumps(result))


if __name__ == "__main__":
    _call()
