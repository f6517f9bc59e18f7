"""Text of decks with the files that they include."""

import re
from collections.abc import Callable
from pathlib import Path, PureWindowsPath

from cea.errors import InputError, require
from meshes.files.sandbox import checked_state

_DEEPEST = 10
"""Files that include one another."""
_LARGEST = 2**33
"""Bytes of a file that is included."""


def text_with_included(
    file: Path,
    pattern: re.Pattern[str],
    included: Callable[[re.Match[str]], tuple[str, str] | None],
    clean: Callable[[str], str] = str,
    chain: tuple[Path, ...] = (),
) -> str:
    """Text of a file with those that it includes in their places.

    Of a match of the pattern, ``included`` gives the text that stays before the file and its path;
    None where it includes none. Paths are counted from the folder of the first file, as solvers
    do, then from that of the file that names them; backslashes separate folders.
    """
    allowed = f"files that do not include each other, at most {_DEEPEST} deep"
    require(file not in chain and len(chain) < _DEEPEST, "file", str(file), allowed)
    chain = (*chain, file)

    def spliced(match: re.Match[str]) -> str:
        if (found := included(match)) is None:
            return match[0]
        other = _named(found[1], chain)
        return f"{found[0]}{text_with_included(other, pattern, included, clean, chain)}\n"

    text = file.read_text("utf-8-sig", "replace")
    return pattern.sub(spliced, clean(text))


def _named(name: str, chain: tuple[Path, ...]) -> Path:
    """A file that another one names."""
    path = PureWindowsPath(name).as_posix()
    for folder in (chain[0].parent, chain[-1].parent):
        for each in (folder / name, folder / path):
            if each.exists():
                return checked_state(each, "a file that is included", _LARGEST)[0]
    allowed = "a file that is included, in capitals and small letters as it is named"
    raise InputError("file", str(chain[0].parent / path), allowed)
