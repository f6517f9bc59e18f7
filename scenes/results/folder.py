"""Folders of results: checked before the work, and replaced as a whole when it is done.

A folder keeps a list of the files that were written to it, each with its digest. What stands there
and is as it was written gives way to the next result; anything else is somebody's own and stays.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from platform import node
from tempfile import TemporaryFile
from typing import Any

from cea.errors import InputError, WriteError
from cea.files import write_whole

MANIFEST = "manifest.json"
"""File that lists what was written to a folder."""
RESULT = "result.json"
"""File that is written last: where it stands, all that belongs to it does."""

_PART = ".part"
"""Ending of folders that are being filled."""
_ABOUT = "Files of this result, with SHA-256. The next result takes their place, and no other's."

_WHOSE = ("scene", "data", "mass", "damping", "stiffness")
"""Inputs of a run that tell whose result it is."""


@dataclass
class NewFolder:
    """A folder that is being filled, and takes the place of another.

    Parameters
    ----------
    part
        Where its files are written.
    out
        Where they will stand.
    kept
        Files that stay since this program did not write them as they are, and under which names;
        known at the end.
    """

    part: Path
    out: Path
    kept: list[str] = field(default_factory=list)

    def final(self, file: Path) -> Path:
        """Where a file that is written in ``part`` will stand."""
        return self.out / file.relative_to(self.part)


def check_out(out: Path, name: str = "out") -> None:
    """Refuse a folder that cannot take a result; it is made where there is none."""
    from scenes.results.record import PROVENANCE, read_record

    try:
        out.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=out):
            pass
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise InputError(name, str(out), f"a folder to write to ({reason})") from None
    if (out / RESULT).exists():
        try:
            ours = set(PROVENANCE) <= read_record(out / RESULT).keys()
        except InputError:
            ours = False
        if not ours:
            allowed = f"a folder without a {RESULT} that something else made"
            raise InputError(name, str(out), allowed)


def check_run_out(out: Path, inputs: Mapping[str, Any], *, overwrite: bool) -> None:
    """Refuse a folder that cannot take the result of a run, or holds that of another scene."""
    from scenes.results.record import read_record

    check_out(out)
    if overwrite or not (out / RESULT).exists():
        return
    found = read_record(out / RESULT)
    stored = {**(found.get("inputs") or {}), "command": found["command"]}
    for name, value in {"command": "run", **{key: inputs.get(key) for key in _WHOSE}}.items():
        if stored.get(name) != value:
            allowed = f"a folder without a result of another {name}, {stored.get(name)!r}"
            raise InputError("out", str(out), f"{allowed}; --overwrite lets it go")


@contextmanager
def new_folder(out: Path, *, root: bool = True) -> Iterator[NewFolder]:
    """A folder to fill, whose files take the place of an earlier result at the end."""
    new = NewFolder(out / f".{node()}.{os.getpid()}{_PART}", out)
    if not root:
        yield new
        return
    try:
        _clear(out)
        new.part.mkdir(parents=True)
        yield new
        _take_place(new)
    except WriteError as error:
        raise WriteError(str(error).replace(str(new.part), str(out))) from error
    except OSError as error:
        raise WriteError(f"{out} cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(new.part, ignore_errors=True)


def listed(out: Path) -> list[str]:
    """Paths of the files that were written to a folder, as its manifest lists them."""
    return sorted(_read(out))


def _clear(out: Path) -> None:
    """Remove what processes of this machine left that were killed as they filled a folder."""
    begin = f".{node()}."
    for left in out.glob(f"*{_PART}"):
        number = left.name.removeprefix(begin).removesuffix(_PART)
        if left.name.startswith(begin) and number.isdecimal() and not _runs(int(number)):
            shutil.rmtree(left, ignore_errors=True)


def _runs(process: int) -> bool:
    """Whether another process of a number runs."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True  # somebody else's
    return process != os.getpid()


def _take_place(new: NewFolder) -> None:
    """Put new files where earlier ones stood, the record of the result last.

    Whenever this ends before its time, what is not listed as it stands is put aside next time.
    """
    files = [file for file in sorted(new.part.rglob("*")) if file.is_file()]
    made = {file.relative_to(new.part).as_posix(): _digest(file) for file in files}
    earlier = _read(new.out)
    (new.out / RESULT).unlink(missing_ok=True)
    for name in earlier.keys() - made.keys():
        _remove(new, name, earlier[name])
    for name in sorted(made, key=lambda name: (name == RESULT, name)):
        file = new.out / name
        for above in reversed([new.out / parent for parent in PurePosixPath(name).parents[:-1]]):
            if above.exists() and not above.is_dir():
                _put_aside(new, above)
        if file.is_symlink() or (file.exists() and not _is_as_written(file, earlier.get(name))):
            _put_aside(new, file)
        file.parent.mkdir(parents=True, exist_ok=True)
        (new.part / name).replace(file)
    content = json.dumps({"about": _ABOUT, "files": made}, indent=1)
    write_whole(f"{content}\n".encode(), new.out / MANIFEST)


def _remove(new: NewFolder, name: str, digest: str) -> None:
    """Remove a file that is as it was written, and folders that are empty then."""
    file = new.out / name
    if not file.is_file() or name == RESULT:
        return
    if file.is_symlink() or not _is_as_written(file, digest):
        new.kept.append(name)
        return
    file.unlink()
    for folder in file.relative_to(new.out).parents[:-1]:
        if any((new.out / folder).iterdir()):
            break
        (new.out / folder).rmdir()


def _put_aside(new: NewFolder, place: Path) -> None:
    """Rename a file or folder to a name that is free."""
    number = 1
    while (other := place.with_name(f"{place.name}.kept{number}")).exists():
        number += 1
    place.replace(other)
    new.kept.append(other.relative_to(new.out).as_posix())


def _read(out: Path) -> dict[str, str]:
    """Digests that the manifest of a folder lists; none where there is none that can be read."""
    try:
        files = json.loads((out / MANIFEST).read_text(encoding="utf-8"))["files"]
        paths = {PurePosixPath(name): str(digest) for name, digest in files.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}
    inside = (path for path in paths if not path.is_absolute() and ".." not in path.parts)
    return {path.as_posix(): paths[path] for path in inside if path.parts}


def _is_as_written(file: Path, digest: str | None) -> bool:
    return file.is_file() and _digest(file) == digest


def _digest(file: Path) -> str:
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
