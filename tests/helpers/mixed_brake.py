"""A disc of hexahedra with wedges at its hub under a pad, as a deck of Abaqus or CalculiX."""

from itertools import pairwise, product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mesh_writers import abaqus_deck
from mpi4py import MPI

from meshes.files.elements import KINDS
from scenes import run_modes
from scenes.spec.reading import read_scene

RADII, HIGH, PAD = (0.03, 0.045, 0.075, 0.08), 0.015, 0.01
"""Bore, rim of the hub and range of the pad, outer radius; thickness of disc and of pad (m)."""
COUNTS = {("hexahedron", 1): 8, ("wedge", 1): 6, ("hexahedron", 2): 20, ("wedge", 2): 15}
MATERIALS = {"DISC": (1.2e11, 0.3, 7200.0), "PAD": (2e10, 0.3, 2500.0)}


class Brake:
    """Elements of disc and pad on a lattice of twice as many steps as elements.

    Parameters
    ----------
    size
        Edge length of elements, at most (m).
    order
        Their order.
    wedges
        Whether the hub is made of wedges.
    bonded
        Whether pad and disc share nodes.
    """

    def __init__(self, size, order, *, wedges, bonded=False):
        self.order = order
        rings = [int(np.ceil((b - a) / size - 1e-9)) for a, b in pairwise(RADII)]
        self.around = int(np.ceil(np.pi / 3 * 0.06 / size))  # of the pad, a sixth of the disc
        high, pad = (int(np.ceil(h / size - 1e-9)) for h in (HIGH, PAD))
        self.radii = np.interp(np.arange(2 * sum(rings) + 1), 2 * np.cumsum([0, *rings]), RADII)
        self.heights = np.concatenate(
            [np.linspace(0, HIGH, 2 * high + 1), HIGH + np.linspace(0, PAD, 2 * pad + 1)]
        )
        self.numbers, self.elements = {}, {"DISC": [], "PAD": []}
        self.above = 0 if bonded else 1
        self.face = 2 * high
        for i, j, k in product(range(sum(rings)), range(6 * self.around), range(high)):
            self._add("DISC", (i, j, k), wedges and i < rings[0])
        for i, j, k in product(range(rings[1]), range(self.around), range(pad)):
            self._add("PAD", (i + rings[0], j, high + k), False)

    def _add(self, part, place, wedge):
        corners = 2 * np.array(place) + 2 * KINDS["hexahedron8"].reference.astype(int)
        cuts = [range(8)]
        if wedge:  # the diagonal turns from element to element
            cuts = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
            if (place[0] + place[1]) % 2:
                cuts = [[0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]]
        cell = "wedge" if wedge else "hexahedron"
        for cut in cuts:
            groups = KINDS[f"{cell}{COUNTS[cell, self.order]}"].groups
            own = [corners[list(cut)][list(group)].mean(axis=0) for group in groups]
            nodes = [self._number(part, tuple(node.astype(int).tolist())) for node in own]
            self.elements[part].append((cell, nodes))

    def _number(self, part, node):
        i, j, k = node
        at = (i, j % (12 * self.around), k + (self.above if part == "PAD" else 0))
        if part == "PAD" and not self.above and k > self.face:
            at = (i, j % (12 * self.around), k + 1)
        return self.numbers.setdefault(at, len(self.numbers) + 1)

    def points(self):
        """Positions (m), in the order of their numbers; CalculiX reads twenty characters."""
        i, j, k = np.array(list(self.numbers)).T
        angle, r = j * np.pi / (6 * self.around), self.radii[i]
        return np.round(
            np.stack([r * np.cos(angle), r * np.sin(angle), self.heights[k]], axis=1), 13
        )

    def sets(self):
        """Numbers of nodes at the bore, on the back of the pad, on both sides of the contact."""
        i, _, k = np.array(list(self.numbers)).T
        found = {"BORE": i == 0, "BACK": k == k.max(), "TOP": k == self.face}
        if self.above:
            found["FACE"] = k == self.face + 1
        return {name: np.flatnonzero(on) + 1 for name, on in found.items()}

    def deck(self):
        """Nodes, elements and sets."""
        solids = []
        for part, cell in product(self.elements, ("hexahedron", "wedge")):
            own = [nodes for kind, nodes in self.elements[part] if kind == cell]
            if own:
                solids.append((part, f"{cell}{COUNTS[cell, self.order]}", np.array(own) - 1))
        sets = {name: numbers - 1 for name, numbers in self.sets().items()}
        return abaqus_deck(self.points(), solids, sets)


def scene(file, *, friction, top=26000.0):
    """The brake of a deck: sliding, or bonded."""
    bodies = {}
    for part, (E, nu, rho) in MATERIALS.items():
        bodies[part.lower()] = {
            "backend": "fe",
            "geometry": {"shape": "mesh_file", "file": str(file), "unit": "m", "part": part},
            "material": {"E": E, "nu": nu, "rho": rho},
            "supports": [{"surface": {"DISC": "BORE", "PAD": "BACK"}[part]}],
            "mesh": {"degree": 2},
        }
    contact = {"a": "pad.FACE", "b": "disc.TOP", "formulation": {"method": "bonded"}}
    contact |= {"P": float("inf"), "form": "saddle"}
    if friction:
        contact |= {
            "formulation": {"method": "mortar"},
            "P": 1e9,
            "mu": friction,
            "form": "penalty",
        }
        contact["friction_direction_on_a"] = {"circumferential_about": [0.0, 0.0, 1.0]}
    analysis = {"kind": "cea", "max_frequency": top}
    return {
        "name": "brake",
        "bodies": bodies,
        "contacts": {"lining": contact},
        "analysis": analysis,
    }


STEEL = (1.2e11, 0.3, 7200.0)


def calculix(brake, modes=20, materials=MATERIALS):
    """The deck of a bonded brake for CalculiX, held at the bore and behind."""
    lines = []
    for part, (E, nu, rho) in materials.items():
        lines += [f"*MATERIAL, NAME={part}", "*ELASTIC", f"{E}, {nu}", "*DENSITY", f"{rho}"]
        lines += [f"*SOLID SECTION, ELSET={part}, MATERIAL={part}"]
    lines += ["*BOUNDARY", "BORE, 1, 3", "BACK, 1, 3"]
    lines += ["*STEP", "*FREQUENCY, STORAGE=YES", f"{modes}", "*END STEP"]
    return brake.deck() + "\n".join(lines) + "\n"


def on_any_number_of_ranks():
    """Eigenvalues of a coarse brake in sliding contact."""
    comm = MPI.COMM_WORLD
    folder = TemporaryDirectory() if comm.rank == 0 else None
    file = Path(comm.bcast(folder.name if folder else None, root=0)) / "brake.inp"
    if comm.rank == 0:
        file.write_text(Brake(0.03, 2, wedges=True).deck())
    comm.barrier()
    found = run_modes(read_scene(scene(file, friction=0.6, top=9000.0))).modes.eigenvalues
    found = found[np.lexsort((found.real.round(3), found.imag.round(3)))]
    comm.barrier()
    if folder is not None:
        folder.cleanup()
    return {"re": found.real.tolist(), "im": found.imag.tolist()}
