"""Folders of results: checked before a run, and replaced as a whole when it is complete.

A folder contains a list of the files of its result. The next result replaces these; all other files
belong to the user and are kept.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Any

from cea.errors import InputError, WriteError, require
from cea.files import write_whole

MANIFEST = "manifest.json"
"""File that lists the files of a result."""
RESULT = "result.json"
"""Record of the result, written last: if it exists, the result is complete."""

_ABOUT = "Files of this result. The next result replaces these files and no others."
_WHOSE = ("scene", "data", "mass", "damping", "stiffness")
"""Inputs of a run that identify its result."""


@dataclass
class NewFolder:
    """A temporary folder whose files will replace the result in another folder."""

    part: Path  # temporary folder in which files are written
    out: Path  # final folder
    # new names of files of the user that were renamed; filled at the end
    kept: list[str] = field(default_factory=list)

    def final(self, file: Path) -> Path:
        """Return the final path of a file in ``part``."""
        return self.out / file.relative_to(self.part)


def check_out(out: Path, name: str = "out") -> dict[str, Any] | None:
    """Create a folder for a result and return the record of an earlier one, if any.

    Raises an InputError if the folder is not writable or contains a foreign ``result.json``.
    """
    from scenes.results.record import PROVENANCE, read_record

    try:
        out.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=out):
            pass
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise InputError(name, str(out), f"a folder to write to ({reason})") from None
    if not (out / RESULT).exists():
        return None
    try:
        found = read_record(out / RESULT)
    except InputError:
        found = {}
    ours = set(PROVENANCE) <= found.keys()
    require(ours, name, str(out), f"a folder without a {RESULT} of another program")
    return found


def check_run_out(out: Path, inputs: Mapping[str, Any], *, overwrite: bool) -> None:
    """Raise an InputError if a folder is not writable or contains the result of another scene."""
    found = check_out(out)
    if overwrite or found is None:
        return
    stored = {**(found.get("inputs") or {}), "command": found["command"]}
    for name, value in {"command": "run", **{key: inputs.get(key) for key in _WHOSE}}.items():
        allowed = f"a folder without a result of another {name}, {stored.get(name)!r}"
        same = stored.get(name) == value
        require(same, "out", str(out), f"{allowed}; --overwrite replaces it")


@contextmanager
def new_folder(out: Path, *, root: bool = True) -> Iterator[NewFolder]:
    """Context of a temporary folder whose files replace an earlier result on exit."""
    if not root:
        yield NewFolder(out, out)
        return
    part = ""
    try:
        out.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(
            dir=out, prefix=".", suffix=".part", ignore_cleanup_errors=True
        ) as part:
            new = NewFolder(Path(part), out)
            yield new
            _take_place(new)
    except WriteError as error:
        raise WriteError(str(error).replace(part, str(out))) from error
    except OSError as error:
        raise WriteError(f"{out} cannot be written: {error.strerror or error}") from error


def listed(out: Path) -> list[str]:
    """Return the relative paths of the files of a result; empty if there is no readable list."""
    try:
        files = json.loads((out / MANIFEST).read_text(encoding="utf-8"))["files"]
        paths = [PurePosixPath(name) for name in files]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []
    inside = (path for path in paths if not path.is_absolute() and ".." not in path.parts)
    return sorted(path.as_posix() for path in inside if path.parts)


def _take_place(new: NewFolder) -> None:
    """Replace the files of the earlier result by the new ones, the record last."""
    files = [file.relative_to(new.part) for file in sorted(new.part.rglob("*")) if file.is_file()]
    made = [file.as_posix() for file in files]
    earlier = [name for name in listed(new.out) if (new.out / name).is_file()]
    (new.out / RESULT).unlink(missing_ok=True)
    for name in earlier:
        (new.out / name).unlink(missing_ok=True)
        for folder in PurePosixPath(name).parents[:-1]:
            with suppress(OSError):  # not empty
                (new.out / folder).rmdir()
    for name in sorted(made, key=lambda name: name == RESULT):
        place = new.out / name
        above = [new.out / folder for folder in reversed(PurePosixPath(name).parents[:-1])]
        for each in (*above, place):
            there = each.exists() or each.is_symlink()
            if there and (each == place or not each.is_dir()):
                _put_aside(new, each)
        place.parent.mkdir(parents=True, exist_ok=True)
        (new.part / name).replace(place)
    content = json.dumps({"about": _ABOUT, "files": made}, indent=1)
    write_whole(f"{content}\n".encode(), new.out / MANIFEST)


def _put_aside(new: NewFolder, place: Path) -> None:
    """Rename a file or folder of the user to an unused name."""
    number = 1
    while (other := place.with_name(f"{place.name}.kept{number}")).exists():
        number += 1
    place.replace(other)
    new.kept.append(other.relative_to(new.out).as_posix())
