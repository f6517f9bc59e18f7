"""Modes of a scene by a process of its own: ``python -m comparisons.bench.own FILE``.

The file holds ``scene``, plain data, and ``mass_quadrature``; the answer takes its place.
"""

import sys
from pathlib import Path
from typing import Any

from cea.body import Body
from fe_cea import LagrangeSpace
from scenes import run_modes
from scenes.building.build import body_mesh
from scenes.results.record import read_record, write_record
from scenes.spec.reading import read_scene


def solve(scene_data: dict[str, Any], mass_quadrature: int | None) -> dict[str, Any]:
    """Modes of a scene of Lagrange bodies.

    Parameters
    ----------
    scene_data
        The scene, plain data.
    mass_quadrature
        Degree of the quadrature of the mass; None, exact.

    Returns
    -------
    dict
        ``eigenvalues`` (1/s) as pairs of real and imaginary part, ``dofs``, ``seconds``.
    """
    scene = read_scene(scene_data)
    bodies = None
    if mass_quadrature is not None:
        bodies = {
            name: Body(
                name,
                LagrangeSpace.from_mesh(
                    body_mesh(name, spec, ()), degree=degree, mass_quadrature=mass_quadrature
                ),
                spec.material,
                supports=[each.support() for each in spec.supports],
            )
            for name, spec in scene.bodies.items()
            if (degree := spec.fe_degree) is not None
        }
    result = run_modes(scene, bodies=bodies)
    return {
        "eigenvalues": [[float(v.real), float(v.imag)] for v in result.eigenvalues],
        "dofs": result.system.size,
        "seconds": result.timer.total,
    }


if __name__ == "__main__":
    file = Path(sys.argv[1])
    write_record(solve(**read_record(file)), file)
