"""A pencil on a basis as arrays, and back: what an interrupted map goes on with at once."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cea.reduced.saddle import SmallContact
from cea.reduced.small import SmallPencil, SmallPiece

Arrays = Mapping[str, NDArray[Any]]
"""Arrays by their names."""
_OF_CONTACTS = ("closes", "slides", "pushes", "rubs")


def arrays_of(small: SmallPencil) -> dict[str, NDArray[Any]]:
    """All numbers of a pencil on a basis; left out are its coefficients, which the pencil has."""
    arrays: dict[str, NDArray[Any]] = {
        "safety": np.array(small.settings.safety),
        "lost": np.array([piece.lost for piece in small.pieces]),
        "rounding": np.array([size for size, _ in small.roundings]),
        "stiffness": np.array([stiff for _, stiff in small.roundings]),
    }
    for number, piece in enumerate(small.pieces):
        arrays[f"square{number}"], arrays[f"right{number}"] = piece.square, piece.right
        if not piece.symmetric:
            arrays[f"left{number}"] = piece.left
    for number, contact in enumerate(small.contacts):
        for name in _OF_CONTACTS:
            arrays[f"{name}{number}"] = getattr(contact, name)
        arrays[f"lost{number}"] = np.array(contact.lost)
    return arrays


def restored(small: SmallPencil, arrays: Arrays) -> SmallPencil:
    """A pencil on no basis yet with the numbers of one that was stored.

    Raises
    ------
    ValueError
        When these are of another pencil.
    """
    if len(arrays["lost"]) != len(small.pieces):
        raise ValueError("pieces of another pencil")
    stiff = [tuple(row) for row in arrays["stiffness"].tolist()]
    return replace(
        small,
        pieces=tuple(_piece(piece, i, arrays) for i, piece in enumerate(small.pieces)),
        settings=replace(small.settings, safety=float(arrays["safety"])),
        roundings=tuple(zip(arrays["rounding"].tolist(), stiff, strict=True)),
        contacts=tuple(_contact(each, i, arrays) for i, each in enumerate(small.contacts)),
    )


def _piece(piece: SmallPiece, number: int, arrays: Arrays) -> SmallPiece:
    right = arrays[f"right{number}"]
    left = arrays.get(f"left{number}", right)
    lost = float(arrays["lost"][number])
    return replace(piece, square=arrays[f"square{number}"], right=right, left=left, lost=lost)


def _contact(contact: SmallContact, number: int, arrays: Arrays) -> SmallContact:
    closes, slides, pushes, rubs = (arrays[f"{name}{number}"] for name in _OF_CONTACTS)
    lost = float(arrays[f"lost{number}"])
    return replace(contact, closes=closes, slides=slides, pushes=pushes, rubs=rubs, lost=lost)
