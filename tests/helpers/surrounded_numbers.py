"""A window of two blocks that rub a little, and what lies around its disc, on any ranks."""

from unittest.mock import patch

from blocks import assemble, two_blocks

from cea.eigen import disc_searches
from cea.eigen.krylov_schur import solve_modes


def surrounded_numbers(backend):
    """Modes, and what the search beside them saw."""
    saw, ask = [], disc_searches.nothing_beside

    def nothing_beside(*arguments):
        saw.append(ask(*arguments))
        return saw[-1]

    data = two_blocks(backend, {"method": "gpts", "points": 3}, held=True, mu=0.05)
    with patch.object(disc_searches, "nothing_beside", nothing_beside):
        modes = solve_modes(assemble(data).pencil(), 0.5)
    return {
        "im": modes.frequencies.tolist(),
        "window": [*saw, modes.window.complete, modes.window.found_below],
    }
