"""Modes as a page shows them: outsides of the bodies, and how they move.

Positions and displacements are kept as whole numbers, fine enough for a screen. What is drawn at
a phase phi is x + s Re(u e^(i phi)), at phase 0 the largest deflection.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.contact.contact import Contact
from cea.eigen.classify import BY_URGENCY, GROWING
from comparisons.kit.binary import STEPS, Binary, quantised
from comparisons.kit.interactive import literal
from comparisons.kit.numbers import growth, number
from scenes import Result

_POINTS = 4000
"""Points of the outsides of a scene, about: more are not seen on a screen."""
_MOST_POINTS = 8000
"""Points from which on outsides are reduced."""
_MOST = 3_000_000
"""Bytes of displacements kept uncompressed, about: the page stays light enough to mail."""
_POSITIONS = 2**16 - 1
"""Steps of a position along the longest side of a scene."""
_CONTACT_POINTS = 600
"""Points of a contact that are shown at most."""
_ARROWS = 24
"""Arrows of friction that are shown at most."""


@dataclass
class Shapes:
    """What the views of a page draw.

    Parameters
    ----------
    scenes
        Plain data of bodies by the key of their result.
    modes
        Plain data of modes by the key of their result, then their number from 1.
    """

    scenes: dict[str, Any] = field(default_factory=dict)
    modes: dict[str, dict[str, Any]] = field(default_factory=dict)
    binary: Binary = field(default_factory=Binary)
    _size: int = 0

    @property
    def keys(self) -> set[str]:
        """Modes that can be shown, as result/number."""
        return {f"{key}/{number}" for key, modes in self.modes.items() for number in modes}

    def plain(self) -> dict[str, Any]:
        """Plain data for the page, beside the text of :attr:`binary`."""
        return {"scenes": self.scenes, "modes": self.modes, "steps": STEPS}

    def add_bodies(self, key: str, result: Result) -> None:
        """Keep the bodies of a result at rest, and its contact points; collective."""
        cells = _cells(result)
        if result.comm.rank == 0:
            self._add_scene(key, result, _outsides(cells, {}))

    def add(
        self,
        key: str,
        result: Result,
        modes: Sequence[int],
        like: str | None = None,
        title: str = "",
    ) -> None:
        """Keep modes of a result, as many as there is room for; collective.

        Parameters
        ----------
        key
            Name of the result.
        result
            The result.
        modes
            Numbers of the modes, from 0, the most important first.
        like
            Key of a result kept before whose bodies are the same.
        title
            What is said of the result.
        """
        from scenes.pictures.drawing import largest_deflection  # brings pyvista

        cells = _cells(result)
        shapes = {
            name: result.mode_shapes(name, each.values, modes, everywhere=False)
            for name, each in cells.items()
        }
        if result.comm.rank:
            return
        outsides = _outsides(cells, shapes)
        if like is None:
            self._add_scene(key, result, outsides)
        kept = self.modes.setdefault(key, {})
        for i, mode in enumerate(modes):
            parts = [s.point_data for s in outsides.values()]
            u = np.concatenate([data[f"real {i}"] + 1j * data[f"imaginary {i}"] for data in parts])
            if self._size + 4 * u.size > _MOST and kept:
                break
            turned, largest = largest_deflection(u)
            kept[str(mode + 1)] = self._mode(turned, largest) | _told(result, mode, title)
            kept[str(mode + 1)]["scene"] = like or key
            self._size += 4 * u.size

    def _add_scene(self, key: str, result: Result, outsides: Mapping[str, Any]) -> None:
        from scenes.pictures.drawing import view_of  # brings pyvista

        points = [surface.points for surface in outsides.values()]
        scene = self._scene(outsides)
        self.scenes[key] = scene | {
            "view": view_of(points).tolist(),
            "flat": not np.ptp(np.concatenate(points)[:, 2]),
            "reduced": any("element" not in s.cell_data for s in outsides.values()),
            "contacts": [self._contact(contact, scene) for contact in result.system.contacts],
        }

    def _contact(self, contact: Contact, scene: Mapping[str, Any]) -> dict[str, Any]:
        """Points of a contact, and where friction pushes side a."""
        points = contact.interface.points
        few = points[_spread(len(points), _CONTACT_POINTS)]
        places = np.clip((_in_space(few.x) - scene["low"]) / scene["step"], 0, _POSITIONS)
        told = {
            "name": literal(contact.name),
            "a": literal(contact.a),
            "points": self.binary.add(np.round(places).T, "uint16"),
        }
        friction = contact.friction
        if friction is None or not friction.acts or len(points) == 0:
            return told
        some = points[_spread(len(points), _ARROWS)]
        along = friction.direction.at(some.x, some.normal)
        arrows = {"from": _in_space(some.x).tolist(), "along": _in_space(along).tolist()}
        return told | {"arrows": arrows}

    def _scene(self, outsides: Mapping[str, Any]) -> dict[str, Any]:
        """Bodies of a scene: positions in a box, triangles, lines."""
        every = np.concatenate([surface.points for surface in outsides.values()])
        low, extent = every.min(axis=0), float(np.ptp(every, axis=0).max())
        bodies = []
        for name, surface in outsides.items():
            places = (surface.points - low) * (_POSITIONS / extent)
            bodies.append(
                {
                    "name": literal(name),
                    "points": self.binary.add(np.round(places).T, "uint16"),
                    "triangles": self.binary.add_numbers(surface.regular_faces.T),
                    "edges": self.binary.add_numbers(_element_edges(surface).T),
                    "sharp": self.binary.add_numbers(_sharp_edges(surface).T),
                }
            )
        return {
            "bodies": bodies,
            "low": low.tolist(),
            "high": every.max(axis=0).tolist(),
            "step": extent / _POSITIONS,
        }

    def _mode(self, turned: Complexes, largest: float) -> dict[str, Any]:
        """Real and imaginary part of a displacement, relative to its largest deflection."""
        real, imaginary = (
            self.binary.add(quantised(_in_space(part), largest).T, "int16")
            for part in (turned.real, turned.imag)
        )
        return {"real": real, "imaginary": imaginary}


def _cells(result: Result) -> dict[str, Any]:
    """Cells of the bodies; collective."""
    from scenes.pictures.grids import merged  # brings pyvista

    return {name: merged(body.space.volume_cells()) for name, body in result.bodies.items()}


def _outsides(cells: Mapping[str, Any], shapes: Mapping[str, Complexes]) -> dict[str, Any]:
    """Outsides of the bodies with no more points than a page has room for, and their modes.

    Their points bear ``real`` and ``imaginary`` displacements by the number of the mode, from 0;
    their triangles, where none was left out, the ``element`` that they are of.
    """
    from scenes.pictures.grids import outside

    fields = {
        name: {
            f"{part} {i}": values
            for i in range(u.shape[2])
            for part, values in (("real", u[..., i].real), ("imaginary", u[..., i].imag))
        }
        for name, u in shapes.items()
    }
    for finer in (2, 1, 0):
        made = {name: outside(each, fields.get(name, {}), finer) for name, each in cells.items()}
        total = sum(surface.n_points for surface in made.values())
        if total <= _POINTS:
            break
    for surface in made.values():
        surface.cell_data["element"] = surface.cell_data["vtkOriginalCellIds"]
    if total <= _MOST_POINTS:
        return made
    share = 1 - _MOST_POINTS / total
    keep: dict[str, Any] = {"preserve_topology": True, "boundary_vertex_deletion": False}
    return {name: s.decimate_pro(share, feature_angle=15.0, **keep) for name, s in made.items()}


def _element_edges(surface: Any) -> Ints:
    """Pairs of points along edges of elements, shape (n, 2); none of what was reduced."""
    if "element" not in surface.cell_data:
        return np.empty((0, 2), dtype=np.int64)
    triangles, element = surface.regular_faces, np.asarray(surface.cell_data["element"])
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    of_elements = np.unique(np.column_stack([pairs, np.repeat(element, 3)]), axis=0)[:, :2]
    edges, count = np.unique(of_elements, axis=0, return_counts=True)
    return edges[count > 1]


def _sharp_edges(surface: Any) -> Ints:
    """Pairs of points along sharp edges, shape (n, 2)."""
    from scenes.pictures.grids import sharp_edges

    numbered = surface.copy(deep=False)
    numbered.point_data["number"] = np.arange(surface.n_points)
    edges = sharp_edges(numbered)
    if not edges.n_points:
        return np.empty((0, 2), dtype=np.int64)
    return np.asarray(edges.point_data["number"])[edges.lines.reshape(-1, 3)[:, 1:]]


def _told(result: Result, mode: int, title: str) -> dict[str, Any]:
    row = result.table()[mode]
    return {
        "number": mode + 1,
        "title": title,
        "frequency": number(row["frequency"], 6),
        "growth": growth(row["growth_rate"]),
        "verdict": row["verdict"],
    }


def by_importance(result: Result) -> list[int]:
    """Numbers of modes from 0: growing ones first, the fastest growing before, then undecided."""
    rows = enumerate(result.table())
    return [
        i
        for i, row in sorted(
            rows,
            key=lambda item: (
                BY_URGENCY.index(item[1]["verdict"]),
                -item[1]["growth_rate"] if item[1]["verdict"] in GROWING else item[0],
            ),
        )
    ]


def _spread(count: int, most: int) -> Ints:
    """Numbers below a count, all of them or as many as may be, evenly spread."""
    return np.unique(np.linspace(0, max(count - 1, 0), min(count, most)).round().astype(np.int64))


def _in_space(vectors: Floats) -> Floats:
    """Vectors with z = 0 added in 2D, shape (n, 3)."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
