"""Bodies from mesh files in small and large units, of flat elements, with wide numbers."""

from collections.abc import Iterator
from typing import Any

from comparisons.stability.parts.case import REFUSED, Run, case
from comparisons.stability.parts.mesh_files import OfMeshFile
from comparisons.stability.parts.references import dense
from comparisons.stability.parts.scenes import layers, pad
from comparisons.stability.parts.ways import QUICK, WAYS, chosen

_FE = chosen(WAYS, *QUICK, backend="fe")


@case("Bodies from mesh files", subject="geometry")
def mesh_files() -> Iterator[Run]:
    """What is written and read again has the eigenvalues it had, or is refused."""
    rows: dict[str, tuple[Any, dict[str, Any]]] = {
        "metres": (layers(), {}),
        "micrometres": (layers(), {"unit": "um"}),
        "feet": (layers(), {"unit": "ft"}),
        "elements of aspect 1e4": (layers(height=1e-4), {}),
        "node numbers to 1e9": (layers(), {"numbers": 10**7}),
        "a pad that ends on its base": (pad(), {"unit": "mm"}),
    }
    for row, (scene, options) in rows.items():
        for way in _FE:
            data = way.of(scene)
            yield Run(row, way, OfMeshFile(data, **options), dense(data))
    for row, change, names in (
        ("no unit", {"unit": None}, "unit"),
        ("two bodies as one", {"part": None}, "part"),
        ("a set that is not there", {"faces": {"y_min": "nowhere"}}, "faces"),
    ):
        for way in _FE:
            problem = OfMeshFile(way.of(layers()), geometry=change)
            yield Run(row, way, problem, None, REFUSED, names=names)
