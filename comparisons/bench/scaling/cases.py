"""Runs of disc_pad that differ in one thing each: ranks, size, or degree."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from cea.errors import InputError
from scenes.spec.reading import Scene, load_scene

SCENE = "disc_pad"
Boxes = tuple[int, int, int]
Kind = Literal["strong", "weak", "size", "degree"]

PAD, DISC = (2, 3, 1), (3, 16, 1)
"""Boxes of the coarsest mesh along r, theta and z; finer ones have each side in as many parts."""
SIZES: Mapping[str, tuple[float, ...]] = {
    "tiny": (1.0, 1.3),
    "medium": (1.6, 2.1, 2.7, 3.4),
    "large": (2.1, 2.7, 3.4, 4.4),
}
"""Factors on the boxes along each side, of the sizes that are run; strong scaling takes the last
but one, weak scaling the first."""
DEGREES: Mapping[str, tuple[int, ...]] = {"fe": (1, 2, 3), "iga": (2, 3, 4)}
_LAGRANGE = 2
"""Degree of all runs that differ in something else."""


@dataclass(frozen=True)
class Case:
    """One run.

    Parameters
    ----------
    kind
        What it is one of a row of.
    ranks
        Number of ranks.
    pad, disc
        Boxes along r, theta and z.
    backend
        Lagrange elements or NURBS.
    degree
        Degree of the functions.
    """

    kind: Kind
    ranks: int
    pad: Boxes
    disc: Boxes
    backend: Literal["fe", "iga"] = "fe"
    degree: int = _LAGRANGE

    def __post_init__(self) -> None:
        if self.ranks < 1:
            raise InputError("ranks", self.ranks, "1 or more")

    @property
    def cell(self) -> str:
        """Hexahedra where degrees are compared, which NURBS have too; else tetrahedra."""
        return "hexahedron" if self.kind == "degree" else "tetrahedron"

    def plain(self) -> dict[str, Any]:
        """The case as a question to a process."""
        return asdict(self) | {"cell": self.cell}


def scene_of(case: Mapping[str, Any]) -> Scene:
    """The scene of a case given as plain data."""
    changes: dict[str, Any] = {}
    for body in ("pad", "disc"):
        mesh = f"bodies.{body}.mesh.{case['backend']}"
        changes[f"{mesh}.elements"] = list(case[body])
        if case["backend"] == "iga":
            changes[f"{mesh}.degree"] = [case["degree"]] * 3
        else:
            changes[f"{mesh}.degree"] = case["degree"]
            changes[f"{mesh}.cell"] = case["cell"]
    return load_scene(SCENE, backend=case["backend"]).change(changes)


def boxes(factor: float) -> tuple[Boxes, Boxes]:
    """Boxes of pad and disc, so many times as many along each side."""
    return _times(PAD, factor), _times(DISC, factor)


def _times(coarse: Boxes, factor: float) -> Boxes:
    r, theta, z = (max(1, round(factor * count)) for count in coarse)
    return r, theta, z


def cases(size: str, ranks: tuple[int, ...]) -> Iterator[Case]:
    """Every run of a size.

    Raises
    ------
    InputError
        When there is no such size.
    """
    if size not in SIZES:
        raise InputError("size", size, f"one of {', '.join(SIZES)}")
    factors = SIZES[size]
    for factor in factors:
        yield Case("size", 1, *boxes(factor))
    for count in ranks:
        yield Case("strong", count, *boxes(factors[-2]))
    for count in ranks:
        pad, disc = boxes(factors[0])
        yield Case("weak", count, _along_theta(pad, count), _along_theta(disc, count))
    pad, disc = boxes(1.0)
    for backend, degrees in (("fe", DEGREES["fe"]), ("iga", DEGREES["iga"])):
        for degree in degrees:
            yield Case("degree", 1, pad, disc, "fe" if backend == "fe" else "iga", degree)


def _along_theta(given: Boxes, times: int) -> Boxes:
    """So many times the boxes along the circumference: unknowns of a rank stay as they are."""
    r, theta, z = given
    return r, times * theta, z
