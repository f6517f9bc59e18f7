"""Find what the project needs from the operating system and pip cannot bring.

Run by the Python that is to make the virtual environment; needs nothing but its standard library.
Without options, exits with status 1 and says what is missing and how to install it; with
``--packages``, writes the names of the missing Debian packages on one line, for scripts.
"""

import ctypes
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

SHARED_LIBRARIES = {  # loaded by gmsh and VTK: (Debian and Ubuntu) package of each
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libGLU.so.1": "libglu1-mesa",
    "libXft.so.2": "libxft2",
    "libXcursor.so.1": "libxcursor1",
    "libXinerama.so.1": "libxinerama1",
}


@dataclass(frozen=True)
class Need:
    """Something missing, why it is needed, and the Debian packages that bring it."""

    what: str
    why: str
    packages: tuple[str, ...]


def python_needs() -> list[Need]:
    """Return what the running Python lacks to make environments and to be compiled against."""
    debian_python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    needs = []
    if importlib.util.find_spec("ensurepip") is None:
        needs.append(Need("ensurepip", "to create .venv", (f"{debian_python}-venv",)))
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        needs.append(Need("Python.h", "to compile finite element forms", (f"{debian_python}-dev",)))
    return needs


def compiler_needs() -> list[Need]:
    """Return what is missing to compile C, which DOLFINx does at run time for every new form."""
    why = "to compile finite element forms"
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    if shutil.which(command[0]) is None:
        package = "clang" if "clang" in command[0] else "gcc"
        return [Need(f"C compiler ({command[0]})", why, (package, "libc6-dev"))]
    trial = [command[0], "-fsyntax-only", "-x", "c", "-"]
    if subprocess.run(trial, input=b"#include <math.h>\n", capture_output=True).returncode:
        return [Need("headers of the C library", why, ("libc6-dev",))]
    return []


def library_needs() -> list[Need]:
    """Return the shared libraries that do not load; each must be there even without a display."""
    needs = []
    for library, package in SHARED_LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            needs.append(Need(library, "for meshing (gmsh) and pictures (pyvista)", (package,)))
    return needs


def main(arguments: list[str]) -> None:
    """Report the missing needs, as text for a person or as package names for a script."""
    if sys.platform != "linux":
        sys.exit(f"DOLFINx is installed from wheels for Linux; this system is {sys.platform}.")
    needs = python_needs() + compiler_needs() + library_needs()
    packages = " ".join(dict.fromkeys(package for need in needs for package in need.packages))
    if arguments == ["--packages"]:
        sys.stdout.write(f"{packages}\n")
    elif needs:
        lines = "\n".join(f"  {need.what}, {need.why}" for need in needs)
        sys.exit(
            f"Missing on this system, for {sys.executable}:\n{lines}\n"
            f"On Debian or Ubuntu:\n  sudo apt-get install {packages}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
