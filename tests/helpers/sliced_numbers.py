"""A window of two blocks in slices: numbers on any ranks."""

from unittest.mock import patch

from blocks import assemble, two_blocks

from cea.eigen import disc_searches
from cea.eigen.krylov_schur import solve_modes
from cea.eigen.slices import Plan

FEW = Plan(columns=72, many=30)
"""Slices where there are few eigenvalues already."""


def sliced_numbers(backend):
    """Modes, and how they were found."""
    pencil = assemble(two_blocks(backend, {"method": "gpts", "points": 3})).pencil()
    with patch.object(disc_searches, "plan_of", lambda *_: FEW):
        modes = solve_modes(pencil, 1.4)
    return {
        "im": modes.frequencies[~modes.rigid].tolist(),
        "window": [modes.window.slices > 1, modes.window.complete, modes.window.found_below],
    }
