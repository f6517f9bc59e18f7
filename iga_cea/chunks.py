"""Work cut into chunks, so that temporaries stay small beside the result."""

from collections.abc import Iterator

BUDGET = 64_000_000
"""Bytes that the temporaries of one chunk may take."""


def chunks(count: int, bytes_each: float) -> Iterator[slice]:
    """Slices that cover ``range(count)``, each within the budget.

    Parameters
    ----------
    count
        Number of items.
    bytes_each
        Bytes of temporaries that one item takes.
    """
    step = max(1, int(BUDGET / bytes_each))
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))
