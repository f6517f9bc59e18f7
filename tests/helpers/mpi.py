"""Programs on any number of ranks, started in one way by the tests of every room.

For each number of ranks one MPI program is started, which then waits for calls: `on_ranks` calls a
function on every rank of it and returns what it returned on rank 0; `cea_on_ranks` runs a command
line there. A call that ends its program fails, and the next one starts another. `mpiexec` starts a
program of its own.
"""

import atexit
import io
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from inspect import getfile
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep

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


def mpiexec(ranks, *command):
    """A command on so many ranks in a program of its own, its output kept."""
    launch = [BIN / "mpiexec", "-n", str(ranks), *command]
    return subprocess.run(
        launch, capture_output=True, text=True, env=ENVIRONMENT, timeout=TIMEOUT, check=False
    )


@cache
def on_ranks(ranks, function, *arguments):
    """What a function of a test or of a helper returns on rank 0 of so many ranks.

    Arguments and result are plain data, ready for JSON. The result is shared: leave it as it is.
    """
    return _program(ranks).call(function, arguments)


def cea_on_ranks(ranks, *arguments):
    """A command line of the program on so many ranks; what rank 0 printed, and its exit code."""
    done = _program(ranks).call(command, [str(each) for each in arguments])
    return subprocess.CompletedProcess(arguments, done["code"], done["out"], done["err"])


def command(*arguments):
    """Run a command line on this rank: its exit code and what it printed."""
    from comparisons.cli.app import main

    out, err, code, before = io.StringIO(), io.StringIO(), 0, sys.argv
    sys.argv = ["cea", *arguments]
    try:
        with redirect_stdout(out), redirect_stderr(err):
            main()
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.argv = before
    return {"code": code, "out": out.getvalue(), "err": err.getvalue()}


class _Program:
    """An MPI program whose ranks wait for calls in a folder, where they cost nothing."""

    def __init__(self, ranks):
        self.folder = TemporaryDirectory(prefix="ranks_", ignore_cleanup_errors=True)
        self.calls = 0
        launch = [BIN / "mpiexec", "-n", str(ranks), sys.executable, __file__, self.folder.name]
        self.log = (Path(self.folder.name) / "log").open("w+")
        self.process = subprocess.Popen(
            launch, stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log, env=ENVIRONMENT
        )
        atexit.register(self.end)

    def call(self, function, arguments):
        """What a function returns on rank 0."""
        answer = _answer(self.folder.name, self.calls)
        question = [getfile(function), function.__name__, arguments]
        _write(_question(self.folder.name, self.calls), question)
        self.calls += 1
        deadline = monotonic() + TIMEOUT
        while not answer.exists():
            if self.process.poll() is not None or monotonic() > deadline:
                self.end()
                self.log.seek(0)
                raise AssertionError(f"{function.__name__} ended its ranks:\n{self.log.read()}")
            sleep(0.01)
        return json.loads(answer.read_text())

    def end(self):
        """End the program, as far as it still runs."""
        self.process.terminate()
        self.process.wait()


_PROGRAMS: dict[int, _Program] = {}


def _program(ranks):
    """The program on so many ranks, started anew where a call ended it."""
    if ranks not in _PROGRAMS or _PROGRAMS[ranks].process.poll() is not None:
        _PROGRAMS[ranks] = _Program(ranks)
    return _PROGRAMS[ranks]


def _question(folder, number):
    return Path(folder) / f"{number}.question"


def _answer(folder, number):
    return Path(folder) / f"{number}.answer"


def _write(file, data):
    """Write plain data; the file is there with all of it, or not at all."""
    part = file.with_suffix(".part")
    part.write_text(json.dumps(data))
    part.rename(file)


@cache
def _module(file):
    """The module in a file, of which two may have one name."""
    spec = spec_from_file_location(Path(file).stem, file)
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def _serve(folder):
    """Answer calls as they come; a fault of any rank ends all of them."""
    from cea.petsc import MPI

    comm, number = MPI.COMM_WORLD, 0
    while True:
        while not _question(folder, number).exists():
            sleep(0.01)
        file, name, arguments = json.loads(_question(folder, number).read_text())
        try:
            result = getattr(_module(file), name)(*arguments)
        except BaseException:
            sys.excepthook(*sys.exc_info())
            sys.stderr.flush()
            comm.Abort(1)
        if comm.rank == 0:
            _write(_answer(folder, number), result)
        number += 1


if __name__ == "__main__":
    _serve(sys.argv[1])
