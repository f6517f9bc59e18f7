"""Modes of your own scene, from TOML text or nested dictionaries."""

import tomllib

from scenes import read_scene, run_modes

SCENE = """
name = "two layers"
[bodies.upper]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 0.5] }
material = { E = 0.1, nu = 0.25, rho = 0.35 }
supports = [{ surface = "y_max" }]
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [16, 4] }
[bodies.lower]
backend = "fe"
geometry = { shape = "rectangle", size = [2.0, 1.0], origin = [0.0, -1.0] }
material = { E = 1.0, nu = 0.3, rho = 1.0 }
supports = [{ surface = "y_min" }]
mesh.fe = { cell = "quadrilateral", degree = 2, elements = [13, 7] }
[contacts.interface]
a = "upper.y_min"
b = "lower.y_max"
formulation = { method = "mortar" }
p = 1.0
mu = 0.5
friction_direction_on_a = { vector = [1.0, 0.0] }
[analysis]
kind = "cea"
max_frequency = 0.4
"""


def lowest_frequency() -> float:
    """Return the lowest frequency (Hz) of the two layers."""
    return float(run_modes(read_scene(tomllib.loads(SCENE))).frequencies.min())


if __name__ == "__main__":
    print(lowest_frequency())
