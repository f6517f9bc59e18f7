"""Folders of results: checked before the work, and replaced as a whole when it is done.

A folder keeps a list of the files that were written to it, which give way to the next result;
anything else is somebody's own and stays.
"""

import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from tempfile import TemporaryFile, mkdtemp
from typing import Any

from cea.errors import InputError, WriteError
from cea.files import write_whole

MANIFEST = "manifest.json"
"""File that lists what was written to a folder."""
RESULT = "result.json"
"""File that is written last: where it stands, all that belongs to it does."""

_ABOUT = "Files of this result. The next result takes their place, and no other's."
_WHOSE = ("scene", "data", "mass", "damping", "stiffness")
"""Inputs of a run that tell whose result it is."""


@dataclass
class NewFolder:
    """A folder that is being filled, and takes the place of another."""

    part: Path  # where its files are written
    out: Path  # where they will stand
    # names of files that were in the way and not of this program; known at the end
    kept: list[str] = field(default_factory=list)

    def final(self, file: Path) -> Path:
        """Where a file that is written in ``part`` will stand."""
        return self.out / file.relative_to(self.part)


def check_out(out: Path, name: str = "out") -> dict[str, Any] | None:
    """Refuse a folder that cannot take a result, or make it; the record of a result there."""
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
    if not set(PROVENANCE) <= found.keys():
        raise InputError(name, str(out), f"a folder without a {RESULT} that something else made")
    return found


def check_run_out(out: Path, inputs: Mapping[str, Any], *, overwrite: bool) -> None:
    """Refuse a folder that cannot take the result of a run, or holds that of another scene."""
    found = check_out(out)
    if overwrite or found is None:
        return
    stored = {**(found.get("inputs") or {}), "command": found["command"]}
    for name, value in {"command": "run", **{key: inputs.get(key) for key in _WHOSE}}.items():
        if stored.get(name) != value:
            allowed = f"a folder without a result of another {name}, {stored.get(name)!r}"
            raise InputError("out", str(out), f"{allowed}; --overwrite lets it go")


@contextmanager
def new_folder(out: Path, *, root: bool = True) -> Iterator[NewFolder]:
    """A folder to fill, whose files take the place of an earlier result at the end."""
    if not root:
        yield NewFolder(out, out)
        return
    part = out
    try:
        out.mkdir(parents=True, exist_ok=True)
        part = Path(mkdtemp(dir=out, prefix=".", suffix=".part"))
        new = NewFolder(part, out)
        yield new
        _take_place(new)
    except WriteError as error:
        raise WriteError(str(error).replace(str(part), str(out))) from error
    except OSError as error:
        raise WriteError(f"{out} cannot be written: {error.strerror or error}") from error
    finally:
        if part != out:
            shutil.rmtree(part, ignore_errors=True)


def listed(out: Path) -> list[str]:
    """Files that were written to a folder, by their paths there; none where no list can be read."""
    try:
        files = json.loads((out / MANIFEST).read_text(encoding="utf-8"))["files"]
        paths = [PurePosixPath(name) for name in files]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []
    inside = (path for path in paths if not path.is_absolute() and ".." not in path.parts)
    return sorted(path.as_posix() for path in inside if path.parts)


def _take_place(new: NewFolder) -> None:
    """Put new files where earlier ones stood, the record of the result last."""
    files = [file.relative_to(new.part) for file in sorted(new.part.rglob("*")) if file.is_file()]
    made = [file.as_posix() for file in files]
    earlier = [name for name in listed(new.out) if (new.out / name).is_file()]
    (new.out / RESULT).unlink(missing_ok=True)
    for name in earlier:
        (new.out / name).unlink(missing_ok=True)
        for folder in PurePosixPath(name).parents[:-1]:
            with suppress(OSError):  # something else is in it
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
    """Rename a file or folder to a name that is free."""
    number = 1
    while (other := place.with_name(f"{place.name}.kept{number}")).exists():
        number += 1
    place.replace(other)
    new.kept.append(other.relative_to(new.out).as_posix())
