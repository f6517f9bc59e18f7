"""Modes of a scene by a process of its own: ``python -m comparisons.peers.own``.

Its one argument is a file with ``scene``, plain data, and ``mass_quadrature``; the answer takes
the place of the file.
"""

import sys
from pathlib import Path
from typing import Any

from scenes.results.record import read_record, write_record


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
        ``eigenvalues`` (1/s) as pairs of real and imaginary part, ``dofs``, ``timings`` by stage.
    """
    from cea.body import Body
    from fe_cea import LagrangeSpace
    from scenes import run_modes
    from scenes.building.body_meshes import body_mesh
    from scenes.spec.reading import read_scene

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
    values = result.eigenvalues
    return {
        "eigenvalues": [[float(value.real), float(value.imag)] for value in values],
        "dofs": result.system.size,
        "timings": dict(result.timer.seconds),
    }


def main(file: Path) -> None:
    """Answer the question that a file holds."""
    question = read_record(file)
    write_record(solve(question["scene"], question["mass_quadrature"]), file)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
