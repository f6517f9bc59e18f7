"""Scenes small enough for CalculiX to run their decks in a moment."""

import shutil

import blocks
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
