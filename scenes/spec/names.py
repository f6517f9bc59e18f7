"""Names as people and files bear them."""

BACKEND_NAMES = {"fe": "finite elements", "iga": "NURBS"}
"""Backends by the name shown."""


def backend_name(backend: str) -> str:
    """Name of a backend as shown; "fe+iga" where bodies of both touch."""
    return " and ".join(BACKEND_NAMES.get(part, part) for part in backend.split("+"))


def file_name(name: str) -> str:
    """Name of a scene as files bear it: signs but letters, digits, _ and - become _."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)
