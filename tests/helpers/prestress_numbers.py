"""Numbers of load steps, prescribed displacements and prestress, for any number of ranks."""

import numpy as np
from pressed import pressed_blocks

from cea.errors import InputError
from scenes import read_scene, run_scene


def history(backend):
    """History, reactions and prestressed eigenvalues of a backend, and how a refusal sounds."""
    data = pressed_blocks(backend, {"method": "gpts", "points": 3}, c_n=100.0, m_n=2.0, mu=0.3)
    data["bodies"]["upper"]["supports"] = [
        {"surface": "z_max", "value": [1e-3, 0.0, -5e-2]},
        {"surface": "x_min", "components": ["z"], "value": -5e-2},
    ]
    data["analysis"] |= {"load_steps": [0.2, 1.0], "geometric_stiffness": True}
    result = run_scene(read_scene(data | {"loads": []}))
    states = [step.state.contacts["interface"] for step in result.steady.path]
    data["bodies"]["upper"]["supports"][1]["value"] = 0.0
    try:
        run_scene(read_scene(data))
        refusal = "none"
    except InputError as error:
        refusal = str(error)
    return {
        "pressure": [np.sort(state.pressure).tolist() for state in states],
        "reactions": {name: force.ravel().tolist() for name, force in result.reactions.items()},
        "eigenvalues": np.abs(result.eigenvalues).tolist(),
        "refusal": refusal,
    }
