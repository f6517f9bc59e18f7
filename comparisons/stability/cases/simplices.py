"""Triangles and tetrahedra."""

from collections.abc import Iterator

from comparisons.stability.parts.case import Run, case
from comparisons.stability.parts.problems import OfScene
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import Scene, body, changed, contact, layers, scene
from comparisons.stability.parts.ways import WAYS, chosen


def _boxes() -> Scene:
    def box(z: float, elements: tuple[int, int, int], held: str) -> Scene:
        geometry = {"shape": "box", "size": [1.0, 1.0, 0.5], "origin": [0.0, 0.0, z]}
        return body(geometry, elements, supports=[{"surface": held}])

    along = {"vector": [1.0, 0.0, 0.0]}
    return scene(
        {"upper": box(0.0, (2, 1, 1), "z_max"), "lower": box(-0.5, (1, 2, 1), "z_min")},
        contact=contact("upper.z_min", "lower.z_max", friction_direction_on_a=along),
    )


@case("Triangles and tetrahedra of degree 1 to 4", subject="elements and splines")
def simplices() -> Iterator[Run]:
    """Cells of a structured mesh divided, on both sides."""
    ways = chosen(WAYS, "node", "GPTS, penalty", "GPTS, saddle", "segments", "mortar", backend="fe")
    for degree in (1, 2, 4):
        for cell, data in (("triangle", layers()), ("tetrahedron", _boxes())):
            if cell == "tetrahedron" and degree > 2:
                continue
            mesh = {
                f"bodies.{name}.mesh.fe.{field}": value
                for name in ("upper", "lower")
                for field, value in (("cell", cell), ("degree", degree))
            }
            for way in ways:
                own = way.of(changed(data, mesh))
                yield Run(f"{cell}, degree {degree}", way, OfScene(own), dense(own))
