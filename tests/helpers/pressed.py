"""Two blocks pressed together by a load, one sliding on the other, as plain data."""

from blocks import two_blocks

PRESSURE, AREA = 1e-3, 0.3
SOFT = 10.0
"""c_n (N/m^3) at which small friction leaves every point closed."""


def pressed_blocks(backend, formulation, *, kind="cea", mu=0.1, pressure=PRESSURE, **contact):
    """A small block, guided sideways, that a pressure on its back presses on a larger one.

    The contact has a stiffness P, p or c_n with m_n, and other fields.
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
