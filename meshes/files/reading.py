"""Mesh files of every format read, once as long as they do not change."""

from functools import lru_cache
from importlib import import_module
from pathlib import Path

import numpy as np

from cea.errors import InputError, require
from meshes.files.content import FileContent
from meshes.files.part import merged
from meshes.files.sandbox import checked_state

_READERS = {
    ".msh": "gmsh.gmsh_content",
    ".inp": "abaqus.abaqus_content",
    ".cdb": "ansys.ansys_content",
    ".bdf": "nastran.nastran_content",
    ".nas": "nastran.nastran_content",
    ".xdmf": "vtk.xdmf_content",
    ".vtu": "vtk.vtu_content",
}
"""Module and function that read files, by their ending; imported when a file is read."""
_KEPT = 4
"""Files whose content is kept, for the bodies of a scene."""
_FARTHEST = 1e50
"""Coordinates whose squares and cubes are numbers."""
_WORDLESS = (TypeError, LookupError, AttributeError, AssertionError)
"""Errors of libraries that say nothing of the file."""


def read_mesh_file(file: Path, merge: float | None = None) -> FileContent:
    """Content of a mesh file."""
    content = _content(*checked_state(file, "a mesh file"))
    return content if merge is None else _merged(content, merge)


@lru_cache(_KEPT)
def _content(file: Path, _changed: int, _size: int) -> FileContent:
    known = _READERS.get(file.suffix.lower())
    if known is None:
        raise InputError("file", str(file), f"one that ends in {', '.join(_READERS)}")
    module, _, function = known.partition(".")
    reader = getattr(import_module(f"meshes.files.{module}"), function)
    try:
        content: FileContent = reader(file)
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


_merged = lru_cache(_KEPT)(merged)
