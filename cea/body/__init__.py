"""Bodies, and the spaces that backends give for them."""

from cea.body.body import Body
from cea.body.space import Space

__all__ = ["Body", "Space"]
