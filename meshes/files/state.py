"""Files of bodies before they are read: there, not empty, not too large."""

from pathlib import Path

from cea.errors import InputError, require
from cea.files import regular


def checked_state(file: Path, what: str, largest: int) -> tuple[Path, int, int]:
    """A file with what tells that it has changed: its path, time of change (ns) and size (bytes).

    Parameters
    ----------
    file
        The file.
    what
        What it should be, for messages.
    largest
        Bytes that it may have.
    """
    try:
        state = regular(file).stat()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError("file", str(file), f"{what} ({reason})") from None
    require(state.st_size > 0, "file", str(file), "a file that is not empty")
    require(state.st_size <= largest, "file", str(file), f"a file of at most {largest} bytes")
    return file.resolve(), state.st_mtime_ns, state.st_size
