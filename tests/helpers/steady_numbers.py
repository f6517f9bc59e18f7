"""Numbers of steady sliding, to be compared between numbers of ranks."""

import numpy as np
from pressed import pressed_blocks

from cea.errors import ConvergenceError
from scenes import read_scene, run_scene

LAW = {"c_n": 100.0, "m_n": 2.5, "mu": 0.3, "added_gap": "0.1*(x-0.45)**2"}
FORMULATIONS = {
    "gpts": {"formulation": {"method": "gpts", "points": 3}},
    "full pass": {"formulation": {"method": "gpts", "points": 3}, "full_pass": True},
    "saddle": {"formulation": {"method": "grid", "points": 5}, "form": "saddle"},
    "mortar": {"formulation": {"method": "mortar"}},
}


def states(*chosen):
    """Contact states and eigenvalues of cases "backend formulation", and how a refusal is heard."""
    found = {}
    for case in chosen:
        backend, name = case.split(" ", 1)
        options = LAW | FORMULATIONS[name]
        data = pressed_blocks(backend, options.pop("formulation"), **options)
        found[case] = numbers(run_scene(read_scene(data)))
    opening = pressed_blocks("fe", FORMULATIONS["gpts"]["formulation"], c_n=1.0, pressure=-1e-3)
    try:
        run_scene(read_scene(opening))
    except ConvergenceError as error:
        found["refusal"] = str(error)
    return found


def numbers(result):
    states = result.steady.contacts
    return {
        "pressure": {name: np.sort(state.pressure).tolist() for name, state in states.items()},
        "stiffness": {name: np.sort(state.stiffness).tolist() for name, state in states.items()},
        "force": np.concatenate([state.force_on_a for state in states.values()]).tolist(),
        "closed": [state.closed_fraction for state in states.values()],
        "eigenvalues": np.abs(result.eigenvalues).tolist(),
    }
