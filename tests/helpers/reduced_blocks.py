"""The blocks of the catalogue near a threshold that their exact solution knows."""

from pathlib import Path

from reference_data import plane_meshes, stored

from cea.eigen.driver import EigenSolver
from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_interfaces, build_system
from scenes.spec.reading import load_scene

MESHES = {
    "fe": {"upper": [8, 2], "lower": [5, 3]},
    "iga": {"upper": [10, 2], "lower": [7, 3]},
}


def flutter_of_the_blocks(backend):
    """A driver, the parameter, values on either side of a threshold, and the window (Hz)."""
    entry = stored("blocks_sine_mu_thresholds")[0]
    overrides = [
        "contacts.interface.mu='sin(pi*x/2)'",
        f"contacts.interface.p={float(entry['p'])}",
        *plane_meshes(backend, 2, MESHES[backend]),
    ]
    scene, timer = load_scene(Path("blocks"), overrides, backend), StageTimer()
    bodies = build_bodies(scene, timer)
    interfaces = build_interfaces(scene, bodies, timer)
    driver = EigenSolver(build_system(scene, bodies, interfaces, timer).pencil())
    mu_c, omega = float(entry["mu_c"]), float(entry["omega"])
    return driver, "contacts.interface.mu", (0.9 * mu_c, 1.1 * mu_c), 1.2 * omega / 6.283185307
