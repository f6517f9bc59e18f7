"""Mode shapes for a page: surfaces of the bodies, and displacements u, as whole numbers.

The page draws x + s Re(u e^(i phi)) at a phase phi; the deflection is largest at phase 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cea.arrays import Complexes, Floats, Ints
from cea.eigen.classify import BY_URGENCY, GROWING
from comparisons.study.numbers import growth, literal, number
from comparisons.study.result import StudyResult
from scenes import Result

STEPS = 2047  # steps of a displacement on either side of zero: finer ones compress badly
_POSITIONS = 2**16 - 1  # steps of a position along the longest side of a scene
_POINTS = 4000  # approximate limit of surface points of a scene: a screen shows no more
_MOST = 1_500_000  # approximate limit of kept displacements, for the size of pages


@dataclass
class Shapes:
    """Plain data that the viewers of a page draw: bodies by the key of their result, and modes.

    Arrays are lists of whole numbers, one for each coordinate or corner.
    """

    scenes: dict[str, Any] = field(default_factory=dict)
    modes: dict[str, dict[str, Any]] = field(default_factory=dict)  # by key, then by number
    _size: int = 0

    def plain(self) -> dict[str, Any]:
        """Plain data, as records and pages hold them."""
        return {"scenes": self.scenes, "modes": self.modes}

    def add(self, key: str, result: Result, modes: Sequence[int], title: str = "") -> None:
        """Keep mode shapes of a result, as many as fit; collective.

        ``modes`` are numbers of modes from 0, the most important first.
        """
        from scenes.results.pictures import largest_deflection  # brings pyvista

        cells = {name: body.space.volume_cells() for name, body in result.bodies.items()}
        shapes = {
            name: result.mode_shapes(name, each.values, modes, everywhere=False)
            for name, each in cells.items()
        }
        if result.comm.rank:
            return
        outsides = _outsides(cells, shapes)
        self._add_scene(key, outsides)
        rows, kept = result.table(), self.modes.setdefault(key, {})
        for i, mode in enumerate(modes):
            parts = [s.point_data for s in outsides.values()]
            u = np.concatenate([data[f"real {i}"] + 1j * data[f"imaginary {i}"] for data in parts])
            if self._size + 2 * u.size > _MOST and kept:
                break
            self._size += 2 * u.size
            turned, largest = largest_deflection(u)
            steps = np.pad(turned * (STEPS / (largest or 1.0)), ((0, 0), (0, 3 - turned.shape[1])))
            kept[str(mode + 1)] = {
                "real": _whole(steps.real),
                "imaginary": _whole(steps.imag),
                "number": mode + 1,
                "title": title,
                "frequency": number(rows[mode]["frequency"], 6),
                "growth": growth(rows[mode]["growth_rate"]),
                "verdict": rows[mode]["verdict"],
                "scene": key,
            }

    def _add_scene(self, key: str, outsides: Mapping[str, Any]) -> None:
        """Keep the bodies of a scene: positions in their bounding box, triangles, lines."""
        from scenes.results.pictures import view_of  # brings pyvista

        points = [surface.points for surface in outsides.values()]
        every = np.concatenate(points)
        low, extent = every.min(axis=0), float(np.ptp(every, axis=0).max())
        step = extent / _POSITIONS

        def kept(surface: Any) -> dict[str, Any]:
            return {
                "points": _whole((surface.points - low) / step),
                "triangles": _whole(surface.regular_faces),
                "edges": _whole(_element_edges(surface)),
                "sharp": _whole(_sharp_edges(surface)),
            }

        self.scenes[key] = {
            "bodies": [{"name": literal(name)} | kept(s) for name, s in outsides.items()],
            "low": low.tolist(),
            "high": every.max(axis=0).tolist(),
            "step": step,
            "view": view_of(points).tolist(),
            "flat": not np.ptp(every[:, 2]),
        }


def merged(result: StudyResult) -> Shapes:
    """Shapes of all cases together."""
    shapes = Shapes()
    for case in result.cases:
        shapes.scenes |= case["shapes"]["scenes"]
        shapes.modes |= case["shapes"]["modes"]
    return shapes


def _whole(values: Floats | Ints) -> list[list[int]]:
    """Round an array, and return a list for each of its columns."""
    return np.round(values).astype(int).T.tolist()


def _outsides(cells: Mapping[str, Any], shapes: Mapping[str, Complexes]) -> dict[str, Any]:
    """Surfaces of the bodies, as fine as the limit of points allows, with their modes.

    Point data ``real i`` and ``imaginary i`` are the displacements of mode i, from 0; cell data
    ``element`` are the elements of the triangles.
    """
    from scenes.results.pictures import outside  # brings pyvista

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
    return made


def _element_edges(surface: Any) -> Ints:
    """Pairs of points along edges of elements, shape (n, 2)."""
    triangles, element = surface.regular_faces, np.asarray(surface.cell_data["element"])
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    of_elements = np.unique(np.column_stack([pairs, np.repeat(element, 3)]), axis=0)[:, :2]
    edges, count = np.unique(of_elements, axis=0, return_counts=True)
    return edges[count > 1]


def _sharp_edges(surface: Any) -> Ints:
    """Pairs of points along sharp edges, shape (n, 2)."""
    from scenes.results.pictures import sharp_edges

    numbered = surface.copy(deep=False)
    numbered.point_data["number"] = np.arange(surface.n_points)
    edges = sharp_edges(numbered)
    if not edges.n_points:
        return np.empty((0, 2), dtype=np.int64)
    return np.asarray(edges.point_data["number"])[edges.lines.reshape(-1, 3)[:, 1:]]


def mode_rows(name: str, result: Result) -> list[dict[str, Any]]:
    """A row for each mode of a result, with the name of its shape."""
    kept = ("mode", "frequency", "damping_ratio", "uncertainty", "verdict")
    return [
        {"shape": f"{name}/{row['mode']}", "growth": row["growth_rate"]}
        | {key: row[key] for key in kept}
        for row in result.table()
    ]


def by_importance(result: Result) -> list[int]:
    """Numbers of modes from 0: growing ones first, by falling growth rate, then undecided ones."""
    rows = result.table()

    def place(i: int) -> tuple[int, float]:
        verdict = rows[i]["verdict"]
        return BY_URGENCY.index(verdict), -rows[i]["growth_rate"] if verdict in GROWING else i

    return sorted(range(len(rows)), key=place)
