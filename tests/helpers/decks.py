"""Scenes small enough for a deck to be read in a test, and decks read back by their keywords."""

import shutil
from pathlib import Path
from typing import NamedTuple

import blocks
import numpy as np
import pytest

from scenes import load_scene, read_scene

P2 = {"cell": "tetrahedron", "degree": 2, "geometry_degree": 1}
STEEL = {"E": 2.1e11, "nu": 0.3, "rho": 7800.0}
ELEMENTS = {"C3D4": ("tetrahedron", 1), "C3D8": ("hexahedron", 1), "C3D10": ("tetrahedron", 2)}


def body(cell, degree):
    """A ring of steel."""
    annulus = {"shape": "annulus", "inner_radius": 0.1, "outer_radius": 0.2}
    mesh = {"cell": cell, "degree": degree, "geometry_degree": 1, "elements": [2, 12, 1]}
    return {
        "backend": "fe",
        "geometry": annulus | {"bottom": 0.0, "top": 0.05},
        "material": STEEL,
        "supports": [{"surface": "inner"}],
        "mesh": {"fe": mesh},
    }


def alone(cell, degree):
    return read_scene(blocks.alone(body(cell, degree), 1e4))


def in_contact(**changes):
    """Disc and pad on a few quadratic tetrahedra."""
    fields = {
        "bodies.pad.mesh.fe": {**P2, "elements": [2, 3, 1]},
        "bodies.disc.mesh.fe": {**P2, "elements": [3, 16, 1]},
        "contacts.pad_disc.formulation": {"method": "segments"},
        "analysis.max_frequency": 9000.0,
    }
    return load_scene("disc_pad", backend="fe").change(fields | changes)


def with_calculix():
    """Skip where CalculiX is not installed."""
    if shutil.which("ccx") is None:
        pytest.skip("ccx is not installed (Debian package calculix-ccx): decks are not run")


class Card(NamedTuple):
    """A keyword with its parameters and data lines, numbers and names as they stand there."""

    keyword: str
    parameters: dict
    rows: list


def cards(file):
    """Cards of a deck, with those of the files that it includes in their place, read by hand."""
    found = []
    for line in Path(file).read_text(encoding="utf-8").splitlines():
        words = [word.strip() for word in line.split(",")]
        if not line.startswith("*"):
            found[-1].rows.append([word for word in words if word])
        elif not line.startswith("**"):
            pairs = (word.partition("=") for word in words[1:])
            parameters = {name.upper(): value for name, _, value in pairs}
            own = [Card(words[0][1:], parameters, [])]
            included = words[0] == "*INCLUDE"
            found += cards(Path(file).parent / parameters["INPUT"]) if included else own
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
