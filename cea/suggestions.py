"""What was probably meant by a name that is not known."""

from collections.abc import Iterable
from difflib import get_close_matches

_ALIKE = 0.6
"""Part of the characters that a name has in common with what was meant."""
_LONGEST = 100
"""Characters of names that are compared: beyond, comparing takes its time."""


def did_you_mean(name: object, known: Iterable[object]) -> str:
    """The end of a message: "; did you mean 'pad'?", or nothing where no known name is near.

    Parameters
    ----------
    name
        What was given.
    known
        The names there are.
    """
    if not isinstance(name, str) or len(name) > _LONGEST:
        return ""
    # What differs in large and small letters alone is nearest.
    folded = {str(each).casefold(): str(each) for each in reversed(list(known))}
    found = get_close_matches(name.strip().casefold(), folded, n=1, cutoff=_ALIKE)
    return f"; did you mean {folded[found[0]]!r}?" if found and folded[found[0]] != name else ""
