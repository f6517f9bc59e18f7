"""Bodies, and the interface of their spaces, which backends implement."""

from cea.body.body import Body
from cea.body.space import Space

__all__ = ["Body", "Space"]
