"""Names as people read them."""

BACKEND_NAMES = {"fe": "finite elements", "iga": "NURBS"}
"""Backends by the name shown."""


def backend_name(backend: str) -> str:
    """Name of a backend as shown; "fe+iga" where bodies of both touch."""
    return " and ".join(BACKEND_NAMES.get(part, part) for part in backend.split("+"))
