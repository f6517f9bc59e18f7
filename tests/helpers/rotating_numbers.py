"""A damped disc that rotates under a pad pressed on it: data, and numbers on any ranks."""

import numpy as np
from damped_numbers import damped_disc

from scenes import run_modes
from scenes.spec.reading import read_scene

DAMPING = {
    "Rayleigh": {"alpha": 0.02, "beta": 0.05},
    "modal": {"modal": {"ratio": 0.03, "max_frequency": 0.3}},
}


def pressed_disc(backend, damping, kind="cea"):
    """The damped disc that rotates under a pad, which a pressure presses on it; with friction."""
    data = damped_disc(backend, c_n=20.0, m_n=1.0, form="penalty")
    data["bodies"]["disc"]["damping"] = DAMPING[damping]
    data["bodies"]["pad"]["supports"] = [{"surface": "top", "components": ["x", "y"]}]
    del data["contacts"]["interface"]["p"]
    del data["contacts"]["interface"]["sliding"]["pressure"]
    data["loads"] = [{"surface": "pad.top", "pressure": 1e-3}]
    data["analysis"] = {"kind": kind} | ({"max_frequency": 0.2} if kind == "cea" else {})
    if kind == "static":
        del data["contacts"]["interface"]["sliding"]
    return data


def numbers(backend, damping):
    """What the contact carries, what is left over, and eigenvalues with derivatives in the rate."""
    result = run_modes(read_scene(pressed_disc(backend, damping)), left=True)
    state, order = result.steady.contacts["interface"], np.argsort(result.eigenvalues.imag)
    slopes = result.modes.sensitivity("bodies.disc.rotation.rate")[order]
    return {
        "residual": result.steady.residual,
        "force": state.force_on_a.tolist(),
        "pressure": np.sort(state.pressure).tolist(),
        "re": result.eigenvalues.real[order].tolist(),
        "im": result.eigenvalues.imag[order].tolist(),
        "slopes": np.abs(slopes).tolist(),
        "reactions": np.concatenate(list(result.reactions.values())).tolist(),
    }
