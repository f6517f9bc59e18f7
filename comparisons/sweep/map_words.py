"""The words of a map, where most grows."""

from collections.abc import Sequence

import numpy as np

from cea.eigen.classify import WORDS, counted_words
from comparisons.kit.numbers import counted
from comparisons.kit.tables import Data
from comparisons.sweep.map_tables import places
from comparisons.sweep.rows import Row


def words_where_most_grows(data: Data, rows: Sequence[Row], threshold: float | None) -> str:
    """How many modes have which word at the value where a mode grows fastest.

    Parameters
    ----------
    data
        The record of the map.
    rows
        Its rows.
    threshold
        Growth rate (1/s) above which a mode is called unstable; None where it is relative.
    """
    values = [
        (at, row.growth[i][row.branch[i] >= 0], row.verdict[i][row.branch[i] >= 0])
        for at, row, i in places(data, rows)
    ]
    at, growth, verdict = max(values, key=lambda value: value[1].max(initial=-np.inf))
    if not len(growth):
        return "No modes at any value."
    axes = [f"{axis['name']} = {value:.6g}" for axis, value in zip(data["axes"], at, strict=True)]
    counts = counted_words([WORDS[i] for i in verdict], growth.tolist(), threshold)
    return f"Most grows at {', '.join(axes)}: {counted(len(growth), 'mode')}: {counts}."
