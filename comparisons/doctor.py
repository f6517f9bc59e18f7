"""Checks of ``cea doctor``: whether this installation works, and how to repair it."""

import ctypes
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Literal

_PROJECT = "friction-cea"
_PATIENCE = 60.0  # time limit of a program (s)
_COUNT = "import sys; from cea.petsc import MPI; sys.stdout.write(f'of {MPI.COMM_WORLD.size};')"
_AGAIN = "make distclean setup"
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
_TOLERANCE = 1e-4  # relative error above which eigenvalues on these meshes are wrong


@dataclass(frozen=True)
class Finding:
    """Result of one check."""

    name: str
    told: str
    mend: str | None = None  # command or advice that repairs a fault; None: no fault


def examine(*, launched: bool) -> Iterator[Finding]:
    """Yield the results of all checks, cheap ones first; ``launched``: started by mpiexec."""
    yield Finding("python", ".".join(map(str, sys.version_info[:3])))
    installed = packages()
    yield installed
    yield compiler()
    yield from libraries()
    if installed.mend:
        return  # the other checks would fail for the same reason
    yield launcher(launched=launched)  # before MPI starts: a launcher does not run inside it
    yield solve("fe")
    yield solve("iga")


def packages() -> Finding:
    """Check with pip that every required package is installed in a suitable version."""
    command = [sys.executable, "-m", "pip", "check"]
    done = subprocess.run(command, capture_output=True, text=True)
    wrong = [line for line in done.stdout.splitlines() if line.startswith(f"{_PROJECT} ")]
    if wrong:
        return Finding("packages", "; ".join(wrong), f"python -m pip install '{_PROJECT}'")
    if done.returncode and not done.stdout.strip():
        reason = (done.stderr.strip() or "pip check failed").splitlines()[-1]
        return Finding("packages", reason, "python -m ensurepip")
    try:
        own = version(_PROJECT)
    except PackageNotFoundError:
        return Finding("packages", f"{_PROJECT} is not installed", _AGAIN)
    return Finding("packages", f"as {_PROJECT} {own} needs them")


def compiler() -> Finding:
    """Check that the C compiler, which compiles finite element forms, finds Python's headers."""
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    mend = f"sudo apt-get install gcc libc6-dev python3.{sys.version_info.minor}-dev"
    if shutil.which(command[0]) is None:
        return Finding("C compiler", f"no {command[0]}", mend)
    header = f"-I{sysconfig.get_path('include')}"
    if _run([*command, header, "-fsyntax-only", "-x", "c", "-"], "#include <Python.h>\n") is None:
        return Finding("C compiler", f"{command[0]} does not compile: no headers", mend)
    return Finding("C compiler", (_run([command[0], "--version"]) or command[0]).splitlines()[0])


def libraries() -> Iterator[Finding]:
    """Check the shared libraries that no Python package installs."""
    for library, package in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            yield Finding(library, "does not load", f"sudo apt-get install {package}")
        else:
            yield Finding(library, "loads")


def launcher(*, launched: bool) -> Finding:
    """Check that mpiexec of the installed MPI starts two ranks, unless it started this process."""
    right = Path(sys.executable).with_name("mpiexec")
    mend = "python -m pip install --force-reinstall mpich"
    if launched:
        return Finding("mpiexec", "started this program")
    if not right.is_file():
        return Finding("mpiexec", f"no {right}", mend)
    told = _run([str(right), "-n", "2", sys.executable, "-c", _COUNT]) or ""
    if told.count("of 2;") != 2:
        mend = f"{mend}; then try: {right} -n 2 hostname"
        return Finding("mpiexec", f"{right} does not start 2 ranks of one program", mend)
    return Finding("mpiexec", f"{right} starts 2 ranks")


def solve(backend: Literal["fe", "iga"]) -> Finding:
    """Check the modes of two blocks in contact against exact eigenvalues."""
    name, start = f"solve on {backend}", perf_counter()
    try:
        error = worst_error(backend)
    except Exception as fault:  # any failure is a finding
        told = f"{type(fault).__name__}: {fault}".splitlines()[0]
        return Finding(name, told, f"{_AGAIN}; if the fault stays, report this message")
    told = f"{perf_counter() - start:.1f} s, error {error:.0e}"
    if error > _TOLERANCE:
        return Finding(name, f"{told}: wrong eigenvalues", _AGAIN)
    return Finding(name, told)


def worst_error(backend: Literal["fe", "iga"]) -> float:
    """Largest relative error of the eigenvalues of the two blocks."""
    import numpy as np

    from scenes import run_modes
    from scenes.spec.reading import load_scene

    found = run_modes(load_scene(_SCENE).on(backend).change(_COARSE)).eigenvalues
    exact = np.array(_EXACT)
    return float((np.abs(found[None] - exact[:, None]).min(axis=1) / np.abs(exact)).max())


def _run(command: list[str], text: str = "") -> str | None:
    """Output of a program; None if it fails or exceeds the time limit."""
    try:
        done = subprocess.run(
            command, input=text, capture_output=True, text=True, timeout=_PATIENCE, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout
