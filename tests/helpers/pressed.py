"""Two blocks pressed together by a load, one sliding on the other, as plain data."""

from blocks import two_blocks

from cea.timing import StageTimer
from scenes.building.build import build_bodies, build_interfaces, build_system
from scenes.spec.reading import read_scene

PRESSURE, AREA = 1e-3, 0.3
SOFT = 10.0
"""c_n (N/m^3) at which small friction leaves every point closed."""


def pressed_blocks(backend, formulation, *, kind="cea", mu=0.1, pressure=PRESSURE, **contact):
    """A small block, guided sideways, that a pressure on its back presses on a larger one.

    Parameters
    ----------
    backend, formulation
        Of both bodies, of the contact.
    kind
        Of the analysis.
    mu, pressure
        Friction coefficient, pressure (N/m^2).
    contact
        Stiffness of the contact, P, p or c_n with m_n, and other fields of it.
    """
    data = two_blocks(backend, formulation, mu=mu, held=True)
    data["bodies"]["upper"]["supports"] = [{"surface": "z_max", "components": ["x", "y"]}]
    del data["contacts"]["interface"]["P"]
    data["contacts"]["interface"] |= contact
    data["loads"] = [{"surface": "upper.z_max", "pressure": pressure}]
    data["analysis"] = {"kind": "cea", "max_frequency": 0.4}
    if kind == "static":
        data["analysis"] = {"kind": "static", "samples": 5}
    return data


def coupled_blocks(*arguments, **options):
    """The system of :func:`pressed_blocks`, before steady sliding is sought."""
    scene, timer = read_scene(pressed_blocks(*arguments, **options)), StageTimer()
    bodies = build_bodies(scene, timer)
    return build_system(scene, bodies, build_interfaces(scene, bodies, timer), timer)
