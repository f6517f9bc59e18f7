"""Decks read back by their keywords, knowing nothing of what wrote them; CalculiX, or a skip."""

import shutil
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest


def with_calculix():
    """Skip where CalculiX is not installed."""
    if shutil.which("ccx") is None:
        pytest.skip("ccx is not installed (Debian package calculix-ccx): decks are not run")


@dataclass
class Card:
    """A keyword with its parameters and data lines, numbers and names as they stand there."""

    keyword: str
    parameters: dict
    rows: list = field(default_factory=list)


def cards(file):
    """Cards of a deck, with those of the files that it includes in their place."""
    found = []
    for line in Path(file).read_text(encoding="utf-8").splitlines():
        if line.startswith("**") or not line.strip():
            continue
        words = [word.strip() for word in line.split(",")]
        if not line.startswith("*"):
            found[-1].rows.append([word for word in words if word])
            continue
        pairs = [word.partition("=") for word in words[1:]]
        parameters = {name.strip().upper(): value.strip() for name, _, value in pairs}
        if words[0] == "*INCLUDE":
            found += cards(Path(file).parent / parameters["INPUT"])
        else:
            found.append(Card(words[0][1:].upper(), parameters))
    return found


def of(deck, keyword, **parameters):
    """Cards of a keyword that have some parameters."""
    return [
        card
        for card in deck
        if card.keyword == keyword
        and all(card.parameters.get(name) == value for name, value in parameters.items())
    ]


def nodes(deck):
    """Coordinates by number."""
    return {
        int(row[0]): np.array(row[1:], dtype=float)
        for card in of(deck, "NODE")
        for row in card.rows
    }


def elements(deck, name):
    """Type of the elements of a set, and their nodes by number."""
    (card,) = of(deck, "ELEMENT", ELSET=name)
    return card.parameters["TYPE"], {int(n): list(map(int, rest)) for n, *rest in card.rows}
