"""The kinds of contact: what becomes of gaps at points, and of contact forces."""

from typing import Literal

Coupling = Literal["pointwise", "lumped", "mortar", "bonded"]
"""What becomes of the gaps at the points of an interface.

``pointwise``: a penalty at each; ``lumped``: the same, the blocks of each side summed onto their
diagonal; ``mortar``: the gap projected on the traces of side a; ``bonded``: as mortar, with every
component of the jump tied.
"""

Form = Literal["penalty", "saddle"]
"""Whether contact forces are eliminated (penalty) or unknowns of their own (saddle)."""
