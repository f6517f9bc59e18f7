"""Problems with exact eigenvalues: scene, meshes, frequency band, exact eigenvalues.

Exact eigenvalues are stored beside the study, because they take longer to compute than the runs.

python -m comparisons.accuracy.problems     # recomputes all of them
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from cea.arrays import Complexes
from cea.files import write_whole
from exact_cea.reference import whole_spectrum

_FAR = 1.15  # end of the exact eigenvalues over that of the band
_REAL = 1e-9  # growth relative to abs(lambda) below which exact growth rates are set to zero
STIFFNESSES = (0.1, 1.0, 10.0, 1000.0)
"""Contact stiffnesses p with stored eigenvalues, in units of each problem."""
FILE = Path(__file__).with_name("exact.json")


@dataclass(frozen=True)
class Problem:
    """A problem with exact eigenvalues, by the name of its scene."""

    name: str
    bodies: Mapping[str, tuple[int, ...]]  # elements of the coarsest meshes of a and b
    in_contact: tuple[int, ...]  # directions along the contact surface
    band: tuple[float, float]  # lowest and highest Im lambda of the modes compared
    mu: float  # friction coefficient, or its amplitude
    solver: str  # name of the problem of exact_cea.reference
    closed: int | None = None  # circumferential direction of a full ring
    unit: float = 1.0  # of the contact stiffness p (N/m^3)
    profile: str = ""  # function of x whose product with mu is the friction coefficient
    depth: float | None = None  # length in z between rollers; None in plane strain and of the ring
    geometry_degree: int | None = None  # of Lagrange elements, if curved sides must match
    most_dofs: int | None = None  # limit at the first p, if the usual one is too coarse

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return len(next(iter(self.bodies.values())))

    def exact(self, stiffness: float) -> Complexes:
        """Compute the exact eigenvalues up to beyond the band; p in units of the problem."""
        values = whole_spectrum(
            self.solver,
            max_frequency=_FAR * self.band[1],
            depth=self.depth,
            p=stiffness * self.unit,
            mu=self.mu,
        ).values
        values = np.where(np.abs(values.real) < _REAL * np.abs(values), 1j * values.imag, values)
        return values[np.lexsort((values.real, values.imag))]

    def parameters(self) -> dict[str, float]:
        """Parameters that stored eigenvalues depend on, besides materials and sizes."""
        return {"unit": self.unit, "mu": self.mu, "highest": _FAR * self.band[1]}


_SINE = "*abs(sin(pi*x/2))"  # abs: rounding of x at a wall must not make it negative
_LAYERS = {"upper": (4, 1), "lower": (3, 2)}
_BLOCKS = {"upper": (4, 1, 3), "lower": (3, 2, 4)}
_RING = {"outer": (1, 12), "inner": (1, 8)}
_WALL = {"outer": (1, 12, 2), "inner": (1, 8, 3)}
_PLATE = {"pad": (1, 12, 1), "disc": (2, 16, 1)}
_BAND = (0.0, 3.3)
_EVERY = (
    Problem("drum", _RING, (1,), (0.0, 2.5), 0.3, "drum", closed=1),
    Problem("drum_3d", _WALL, (1, 2), (0.0, 2.2), 0.7, "drum", closed=1, depth=1.0),
    Problem("blocks", _LAYERS, (0,), _BAND, 1.0, "blocks", profile=_SINE),
    Problem("blocks_constant_mu", _LAYERS, (0,), _BAND, 0.7, "blocks_constant"),
    Problem("blocks_3d", _BLOCKS, (0, 2), (0.0, 2.8), 1.0, "blocks", profile=_SINE, depth=2.0),
    Problem(
        "ring",
        _PLATE,
        (0, 1),
        (1e4, 9e4),
        0.3,
        "ring",
        closed=1,
        unit=1e12,
        geometry_degree=4,
        most_dofs=13_000,
    ),
)
PROBLEMS = {problem.name: problem for problem in _EVERY}
"""Problems by name; the meshes of the bodies do not match."""


@cache
def exact(name: str, stiffness: float) -> Complexes:
    """Return the exact eigenvalues of a problem, stored or computed; p in its units."""
    chosen, entry = PROBLEMS[name], json.loads(FILE.read_text()).get(name, {})
    found = entry.get("lists", {}).get(f"{stiffness:g}")
    if found is None or entry["parameters"] != chosen.parameters():
        return chosen.exact(stiffness)
    return np.array([complex(re, im) for re, im in found])


if __name__ == "__main__":
    data = {
        name: {
            "parameters": chosen.parameters(),
            "lists": {f"{p:g}": [[v.real, v.imag] for v in chosen.exact(p)] for p in STIFFNESSES},
        }
        for name, chosen in PROBLEMS.items()
    }
    # One line per list makes differences readable.
    lines = json.dumps(data).replace('": [[', '":\n[[').replace("]], ", "]],\n") + "\n"
    write_whole(lines.encode(), FILE)
