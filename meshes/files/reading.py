"""Reading of files of meshes and of patches, once as long as they do not change."""

from collections.abc import Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from cea.errors import InputError
from meshes.files.content import FileContent
from meshes.files.part import merged
from meshes.files.sandbox import checked_state

_MESHES = {
    ".msh": "meshes.files.gmsh.gmsh_content",
    ".inp": "meshes.files.abaqus.abaqus_content",
    ".cdb": "meshes.files.ansys.ansys_content",
    ".bdf": "meshes.files.nastran.nastran_content",
    ".nas": "meshes.files.nastran.nastran_content",
    ".xdmf": "meshes.files.vtk.xdmf_content",
    ".vtu": "meshes.files.vtk.vtu_content",
}
_KEPT = 4
"""Number of files whose content is cached, for the bodies of a scene."""
_WORDLESS = (
    TypeError,
    LookupError,
    AttributeError,
    AssertionError,
    SyntaxError,
    RecursionError,
)
"""Errors of libraries whose messages do not describe the file."""


def read_mesh_file(file: Path, merge: float | None = None) -> FileContent:
    """Content of a mesh file, with nodes nearer than ``merge`` merged."""
    content = read_once(file, "a mesh file", _MESHES)
    return content if merge is None else _merged(content, merge)


def read_once(file: Path, what: str, readers: Mapping[str, str], **limits: int) -> Any:
    """Result of the reader of a file, a function chosen by its extension and imported here."""
    reader = readers.get(file.suffix.lower())
    state = checked_state(file, what, **limits)
    if reader is None:
        raise InputError("file", str(file), f"one that ends in {' or '.join(readers)}")
    return _read(reader, *state)


@lru_cache(_KEPT)
def _read(reader: str, file: Path, _changed: int, _size: int) -> Any:
    module, _, function = reader.rpartition(".")
    read = getattr(import_module(module), function)
    try:
        return read(file)
    except InputError as error:
        told = error.value if error.field == "file" else error.field
        name = f"{file.name}: {told}" if told != str(file) else told
        raise InputError("file", name, error.allowed) from None
    except MemoryError:
        raise
    except Exception as error:  # libraries raise any error on a broken file
        told = str(error) if not isinstance(error, _WORDLESS) else ""
        reason = told or "it does not follow its format"
        allowed = f"a whole {file.suffix} file; it cannot be read ({reason})"
        raise InputError("file", str(file), allowed) from None


_merged = lru_cache(_KEPT)(merged)
