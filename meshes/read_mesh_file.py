"""Mesh files of every format read, once as long as they do not change."""

import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

from cea.errors import InputError, require
from meshes.files.content import FileContent
from meshes.files.gmsh_content import gmsh_content
from meshes.files.part import merged
from meshes.files.state import checked_state

_KEPT = 4
"""Files whose content is kept, for the bodies of a scene."""
_FARTHEST = 1e50
"""Coordinates whose squares and cubes are numbers."""
_LARGEST = 2**33
"""Bytes of a file."""
_ELSEWHERE = re.compile(
    rb"(?mi)^(GRID    [^,\n]{8} {0,7}[1-9]|GRID\*   [^,\n]{16} {0,15}[1-9]"
    rb"|GRID\*? *,[^,\n]*, *[1-9]|INCLUDE)"
)
"""Points of Nastran in a system of their own, and files in files."""
_END = re.compile(rb"(?mi)^ENDDATA")
_CARD = re.compile(rb"(?mi)^(C[A-Z]+\d*|RBE\d|RBAR|RROD)\*?(?=[\s,])")
_READ_CARDS = (
    *("CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CTRIA3", "CTRIA6", "CQUAD4", "CQUAD8", "CEND"),
    *("CORD1R", "CORD2R", "CORD1C", "CORD2C", "CORD1S", "CORD2S", "CTRIAR", "CQUADR"),
)


_WORDLESS = (TypeError, LookupError, AttributeError, AssertionError)
"""Errors of libraries that say nothing of the file."""


def read_mesh_file(file: Path, merge: float | None = None) -> FileContent:
    """Content of a mesh file.

    Parameters
    ----------
    file
        The file; its ending tells the format: .msh (gmsh), .inp (Abaqus, CalculiX), .cdb (Ansys),
        .bdf, .nas (Nastran), .xdmf, .vtu.
    merge
        Distance, in the unit of the file, within which nodes are made one.

    Raises
    ------
    InputError
        Naming file, when it is not there, of another format, or not as its format has it.
    """
    content = _content(*checked_state(file, "a mesh file", _LARGEST))
    return content if merge is None else _merged(content, merge)


@lru_cache(_KEPT)
def _content(file: Path, _changed: int, _size: int) -> FileContent:
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise InputError("file", str(file), f"one that ends in {', '.join(_READERS)}")
    try:
        content = reader(file)
        fits = bool((np.abs(content.points) < _FARTHEST).all())
        require(fits, "file", "nodes", f"finite coordinates, below {_FARTHEST:g}")
        return content
    except InputError as error:
        name = f"{file.name}: {error.value}" if error.value != str(file) else error.value
        raise InputError("file", name, error.allowed) from None
    except MemoryError:
        raise
    except Exception as error:  # libraries raise whatever comes up in a broken file
        told = str(error) if not isinstance(error, _WORDLESS) else ""
        reason = told or "it is not as its format has it"
        allowed = f"a whole {file.suffix} file; it cannot be read ({reason})"
        raise InputError("file", str(file), allowed) from None


@lru_cache(_KEPT)
def _merged(content: FileContent, distance: float) -> FileContent:
    return merged(content, distance)


def _gmsh(file: Path) -> FileContent:
    with file.open("rb") as stream:
        require(stream.read(11) == b"$MeshFormat", "file", str(file), "a .msh file of gmsh")
    return gmsh_content(file)


def _nastran(file: Path) -> FileContent:
    text = file.read_bytes()
    if match := _ELSEWHERE.search(text):
        value = match[0].decode("ascii", "replace")
        allowed = "one file whose GRID points are in the basic coordinate system (CP = 0)"
        raise InputError("file", value, allowed)
    allowed = "a whole file, which ends with ENDDATA"
    require(_END.search(text) is not None, "file", str(file), allowed)
    cards = {match[1].decode("ascii").upper() for match in _CARD.finditer(text)}
    content = gmsh_content(file, shells_bear=True)
    return content.with_others(sorted(cards - set(_READ_CARDS)))


def _abaqus(file: Path) -> FileContent:
    from meshes.files.abaqus import abaqus_content

    return abaqus_content(file)


def _ansys(file: Path) -> FileContent:
    from meshes.files.ansys_content import ansys_content

    return ansys_content(file)


def _vtu(file: Path) -> FileContent:
    from meshes.files.vtk import vtu_content

    return vtu_content(file)


def _xdmf(file: Path) -> FileContent:
    from meshes.files.vtk import xdmf_content

    return xdmf_content(file)


_READERS: dict[str, Callable[[Path], FileContent]] = {
    ".msh": _gmsh,
    ".inp": _abaqus,
    ".cdb": _ansys,
    ".bdf": _nastran,
    ".nas": _nastran,
    ".xdmf": _xdmf,
    ".vtu": _vtu,
}
"""Readers by the ending of a file."""
