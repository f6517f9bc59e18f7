"""A stored run as plain data."""

from math import inf

from bad_inputs import valid

from scenes.results.record import record

WINDOW = {
    "max_frequency": 1.0,
    "shift": 2.0,
    "radius": inf,
    "found": 1,
    "discs": 1,
    "upper": 3.0,
    "found_below": 1,
    "symmetric_count": 1,
    "max_growth": inf,
    "bounded": True,
    "odd": False,
}


def a_record():
    """Content of a stored run, with a window that holds the whole spectrum."""
    run = {
        "scene": valid("blocks"),
        "dofs": {"free": 3, "bodies": {"upper": 2, "lower": 1}},
        "timings": {"meshing": 0.1},
        "skipped": {"newton": "none"},
        "contacts": {},
        "eigenvalues": [dict.fromkeys(("re", "im", "residual", "condition", "uncertainty"), 0.5)],
        "window": WINDOW,
        "unstable": [],
    }
    return record("run", run, inputs={"scene": "blocks"}, seconds=0.5)
