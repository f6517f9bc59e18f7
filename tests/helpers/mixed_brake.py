"""A disc of hexahedra with wedges at its hub under a pad: its deck, and a scene of it."""

from itertools import pairwise, product

import numpy as np
from mesh_writers import abaqus_deck

from meshes.files.elements import KINDS

RADII, HIGH, PAD = (0.03, 0.045, 0.075, 0.08), 0.015, 0.01
"""Bore, rim of the hub and range of the pad, outer radius; thickness of disc and of pad (m)."""
NODES = {"hexahedron": "hexahedron20", "wedge": "wedge15"}
MATERIALS = {"DISC": (1.2e11, 0.3, 7200.0), "PAD": (2e10, 0.3, 2500.0)}


def brake(size, *, shared=False):
    """A deck of quadratic hexahedra of some size (m) with wedges at the hub of the disc.

    Nodes lie on a lattice of twice as many steps as elements; pad and disc may share theirs.
    """
    rings = [int(np.ceil((b - a) / size - 1e-9)) for a, b in pairwise(RADII)]
    around = int(np.ceil(np.pi / 3 * 0.06 / size))  # of the pad, a sixth of the disc
    high, thick = (int(np.ceil(h / size - 1e-9)) for h in (HIGH, PAD))
    numbers, elements = {}, {place: [] for place in product(MATERIALS, NODES)}

    def number(part, node):
        i, j, k = (node + 0.5).astype(int).tolist()
        above = part == "PAD" and (not shared or k > 2 * high)
        return numbers.setdefault((i, j % (12 * around), k + above), len(numbers))

    def add(part, place, *, wedges=False):
        corners = 2 * np.array(place) + 2 * KINDS["hexahedron8"].reference.astype(int)
        cell, cuts = "hexahedron", [range(8)]
        if wedges:  # the diagonal turns from element to element
            cell, cuts = "wedge", [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
            if (place[0] + place[1]) % 2:
                cuts = [[0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]]
        for cut in cuts:
            own = (corners[list(cut)][list(g)].mean(axis=0) for g in KINDS[NODES[cell]].groups)
            elements[part, cell].append([number(part, node) for node in own])

    for i, j, k in product(range(sum(rings)), range(6 * around), range(high)):
        add("DISC", (i, j, k), wedges=i < rings[0])
    for i, j, k in product(range(rings[1]), range(around), range(thick)):
        add("PAD", (i + rings[0], j, high + k))
    i, j, k = np.array(list(numbers)).T
    radii = np.interp(np.arange(2 * sum(rings) + 1), 2 * np.cumsum([0, *rings]), RADII)
    heights = [np.linspace(0, HIGH, 2 * high + 1), HIGH + np.linspace(0, PAD, 2 * thick + 1)]
    angle, r = j * np.pi / (6 * around), radii[i]
    x = np.stack([r * np.cos(angle), r * np.sin(angle), np.concatenate(heights)[k]], axis=1)
    sets = {"BORE": i == 0, "BACK": k == k.max(), "TOP": k == 2 * high, "FACE": k == 2 * high + 1}
    if shared:
        del sets["FACE"]
    return abaqus_deck(
        np.round(x, 13),  # CalculiX reads twenty characters
        [(part, NODES[cell], np.array(own)) for (part, cell), own in elements.items() if own],
        {name: np.flatnonzero(on) for name, on in sets.items()},
    )


def scene(file, *, friction=0.0, top=26000.0):
    """The brake of a deck as plain data: sliding, or bonded."""
    bodies = {
        part.lower(): {
            "backend": "fe",
            "geometry": {"shape": "mesh_file", "file": str(file), "unit": "m", "part": part},
            "material": {"E": E, "nu": nu, "rho": rho},
            "supports": [{"surface": {"DISC": "BORE", "PAD": "BACK"}[part]}],
            "mesh": {"degree": 2},
        }
        for part, (E, nu, rho) in MATERIALS.items()
    }
    bonded = {"formulation": {"method": "bonded"}, "P": float("inf"), "form": "saddle"}
    sliding = {
        "formulation": {"method": "mortar"},
        "P": 1e9,
        "mu": friction,
        "form": "penalty",
        "friction_direction_on_a": {"circumferential_about": [0.0, 0.0, 1.0]},
    }
    lining = {"a": "pad.FACE", "b": "disc.TOP"} | (sliding if friction else bonded)
    return {
        "name": "brake",
        "bodies": bodies,
        "contacts": {"lining": lining},
        "analysis": {"kind": "cea", "max_frequency": top},
    }
