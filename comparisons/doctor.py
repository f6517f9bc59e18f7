"""Checks of ``cea doctor``: whether this installation works, and how to repair it."""

import ctypes
import os
import shlex
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Literal

_PROJECT = "friction-cea"
_PATIENCE = 60.0  # time limit of a program (s)
_COUNT = "import sys; from cea.petsc import MPI; sys.stdout.write(f'of {MPI.COMM_WORLD.size};')"
LIBRARIES = {"libGL.so.1": "libgl1", "libEGL.so.1": "libegl1", "libGLU.so.1": "libglu1-mesa"}
"""Shared libraries that meshing with gmsh and pictures need, and their packages on Debian."""
_SCENE = "blocks"
_COARSE = {
    f"bodies.{body}.mesh": {
        "fe": {"cell": "quadrilateral", "degree": 3, "elements": elements},
        "iga": {"degree": [3, 3], "elements": elements},
    }
    for body, elements in (("upper", [8, 3]), ("lower", [7, 4]))
}
_EXACT = (1.374601231794j, 1.767482480613j, 1.825025163132j, 1.953583329521j, 2.024977609479j)
"""The first five exact eigenvalues, from ``cea exact blocks --count 5``."""
_TOLERANCE = 1e-5  # relative error above which eigenvalues on these meshes are wrong


@dataclass(frozen=True)
class Finding:
    """Result of one check."""

    name: str
    told: str
    mend: str | None = None  # command or advice that repairs a fault; None: no fault


def examine(*, launched: bool) -> Iterator[Finding]:
    """Yield the results of all checks, cheap ones first; ``launched``: started by mpiexec."""
    for name, check, mend in _checks(launched):
        try:
            yield Finding(name, check())
        except Exception as fault:  # any failure is a finding
            yield Finding(name, f"{type(fault).__name__}: {fault}".splitlines()[0], mend)
            if check is packages:
                return  # the checks after it would fail for the same reason


def _checks(launched: bool) -> Iterator[tuple[str, Callable[[], str], str]]:
    """Yield name, function and repair of each check; functions raise what is wrong."""
    headers = f"libc6-dev python3.{sys.version_info.minor}-dev"
    yield "C compiler", compiler, f"sudo apt-get install gcc {headers}"
    for library, package in LIBRARIES.items():
        yield library, partial(loads, library), f"sudo apt-get install {package}"
    yield "packages", packages, f"python -m pip install '{_PROJECT}'"
    if not launched:  # before MPI starts: a launcher does not run inside it
        yield "mpiexec", launcher, "python -m pip install --force-reinstall mpich"
    again = "make distclean setup; if the fault stays, report this message"
    yield "solve on fe", partial(solve, "fe"), again
    yield "solve on iga", partial(solve, "iga"), again


def compiler() -> str:
    """Check that the C compiler, which compiles finite element forms, finds Python's headers."""
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    header = f"-I{sysconfig.get_path('include')}"
    _run([*command, header, "-fsyntax-only", "-x", "c", "-"], "#include <Python.h>\n")
    return f"{command[0]} compiles"


def loads(library: str) -> str:
    """Check a shared library that no Python package installs."""
    ctypes.CDLL(library)
    return "loads"


def packages() -> str:
    """Check with pip that every required package is installed in a suitable version."""
    told = _run([sys.executable, "-m", "pip", "check"], check=False).splitlines()
    wrong = [line for line in told if line.startswith(f"{_PROJECT} ")]
    if wrong or not told:
        raise RuntimeError("; ".join(wrong) or "pip does not run")
    return f"as {_PROJECT} needs them"


def launcher() -> str:
    """Check that mpiexec of the installed MPI starts two ranks."""
    right = str(Path(sys.executable).with_name("mpiexec"))
    if _run([right, "-n", "2", sys.executable, "-c", _COUNT]).count("of 2;") != 2:
        raise RuntimeError(f"{right} does not start 2 ranks of one program")
    return f"{right} starts 2 ranks"


def solve(backend: Literal["fe", "iga"]) -> str:
    """Check the modes of two blocks in contact against exact eigenvalues."""
    import numpy as np

    from scenes import load_scene, run_modes

    start, exact = perf_counter(), np.array(_EXACT)
    found = run_modes(load_scene(_SCENE).on(backend).change(_COARSE)).eigenvalues
    error = (np.abs(found[None] - exact[:, None]).min(axis=1) / np.abs(exact)).max()
    if error > _TOLERANCE:
        raise RuntimeError(f"wrong eigenvalues, error {error:.0e}")
    return f"{perf_counter() - start:.1f} s, error {error:.0e}"


def _run(command: list[str], text: str = "", *, check: bool = True) -> str:
    """Output of a program; one that fails, is missing or takes too long raises an error."""
    done = subprocess.run(
        command, input=text, capture_output=True, text=True, timeout=_PATIENCE, check=check
    )
    return done.stdout
