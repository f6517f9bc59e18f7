"""What the operating system brings: a C compiler, MPI and its launcher, memory."""

import ctypes
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path

from comparisons.doctor.finding import Finding

_RANKS = 2
_PATIENCE = 60.0
"""Seconds that a program may take."""
_COUNT = "import sys; from cea.petsc import MPI; sys.stdout.write(f'of {MPI.COMM_WORLD.size};')"
_LITTLE = 2e9
"""Bytes of memory below which even the scenes of the project do not all run."""


def compiler() -> Finding:
    """The C compiler, which forms of finite elements are compiled with when first used."""
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    mend = "sudo apt-get install gcc libc6-dev"
    if shutil.which(command[0]) is None:
        return Finding("C compiler", f"no {command[0]}", mend)
    trial = [*command, "-fsyntax-only", "-x", "c", "-"]
    if _run(trial, "#include <math.h>\n") is None:
        return Finding("C compiler", f"{command[0]} compiles nothing: no headers of C", mend)
    told = _run([command[0], "--version"]) or command[0]
    return Finding("C compiler", told.splitlines()[0])


def python_header() -> Finding:
    """The header that compiled forms include."""
    header = Path(sysconfig.get_path("include"), "Python.h")
    if header.is_file():
        return Finding("Python.h", str(header))
    name = f"python{sys.version_info.major}.{sys.version_info.minor}-dev"
    return Finding("Python.h", "not there", f"sudo apt-get install {name}")


LIBRARIES = {"libGL.so.1": "libgl1", "libEGL.so.1": "libegl1", "libGLU.so.1": "libglu1-mesa"}
"""Shared libraries that meshing with gmsh and pictures need, and their packages on Debian."""


def libraries() -> Iterator[Finding]:
    """Shared libraries that no Python package brings."""
    for library, package in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            yield Finding(library, "does not load", f"sudo apt-get install {package}")
        else:
            yield Finding(library, "loads")


def launcher(*, launched: bool) -> Finding:
    """The mpiexec of the MPI that the packages use, tried on two ranks.

    Parameters
    ----------
    launched
        Whether a launcher began this process: it then works, and would not begin another inside.
    """
    right = Path(sys.executable).with_name("mpiexec")
    if launched:
        return Finding("mpiexec", "began this program")
    if not right.is_file():
        mend = "python -m pip install --force-reinstall mpich"
        return Finding("mpiexec", f"no {right}", mend)
    told = _run([str(right), "-n", str(_RANKS), sys.executable, "-c", _COUNT]) or ""
    if told.count(f"of {_RANKS};") != _RANKS:
        mend = f"python -m pip install --force-reinstall mpich; then try: {right} -n 2 hostname"
        return Finding("mpiexec", f"{right} does not start {_RANKS} ranks of one program", mend)
    other = shutil.which("mpiexec")
    beside = "" if other is None or Path(other).samefile(right) else f"; {other} is another, not it"
    return Finding("mpiexec", f"{right} starts {_RANKS} ranks{beside}")


def memory() -> Finding:
    """Memory that a run may have."""
    from scenes.checking.memory import available_memory

    available = available_memory()
    told = f"{available / 1e9:.1f} GB"
    if available < _LITTLE:
        return Finding("memory", told, "raise the limit: ulimit -v unlimited, or that of the group")
    return Finding("memory", told)


def _run(command: list[str], text: str = "") -> str | None:
    """What a program prints; None where it fails or does not end."""
    try:
        done = subprocess.run(
            command, input=text, capture_output=True, text=True, timeout=_PATIENCE, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout
