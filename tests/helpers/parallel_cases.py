"""Small scenes on any number of ranks: what must not depend on that number.

`case` runs one of `CASES`.
"""

from unittest.mock import patch

import numpy as np
from bad_inputs import coarse
from blocks import SECTIONS, alone, block, two_blocks
from motions import asymmetry

from cea.eigen.krylov_schur import KrylovOptions
from scenes import run_modes, run_scene
from scenes.spec.plain import checked
from scenes.spec.reading import read_scene

in_krylov_spaces = patch("cea.eigen.driver.KrylovOptions", lambda: KrylovOptions(dense_limit=0))
"""Small systems are searched like large ones, which ranks share: LAPACK would solve them whole."""
GRID, GPTS = {"method": "grid", "points": 5}, {"method": "gpts", "points": 4}
ONE_POINT = {"method": "gpts", "points": 1}


FORMULATIONS = {
    "collocation": {},
    "grid": {"formulation": GRID},
    "gpts": {"formulation": GPTS},
    "lumped": {"formulation": GPTS | {"lumped": True}},
    "full pass": {"formulation": GPTS, "full_pass": True},
    "segments": {"formulation": {"method": "segments"}},
    "mortar": {"formulation": {"method": "mortar"}},
    "tied mortar": {"formulation": {"method": "mortar"}, "form": "saddle", "P": float("inf")},
}
"""What each changes in a contact of collocation."""


def blocks(backend, contact="gpts", mu=1.0):
    """Two blocks that flutter, and few modes: each takes messages, slow where ranks share cores."""
    collocation = {"method": {"fe": "node_to_surface", "iga": "greville"}[backend]}
    data = two_blocks(backend, collocation, held=True, mu=mu, P=30.0)
    data["contacts"]["interface"] |= FORMULATIONS[contact]
    return data | {"analysis": {"kind": "cea", "max_frequency": 0.55, "growth_threshold": 1e-3}}


def static(data):
    loads = [{"surface": "upper.x_min", "pressure": 0.02}]
    return data | {"analysis": {"kind": "static", "samples": 7}, "loads": loads}


def overhanging(data):
    data["bodies"]["upper"]["geometry"]["origin"][0] = 0.75
    data["contacts"]["interface"]["max_missed"] = 0.6
    return data


def single_point(backend):
    """Fewer contact points than ranks."""
    data = blocks(backend)
    data["contacts"]["interface"]["formulation"] = ONE_POINT
    for mesh in data["bodies"]["upper"]["mesh"].values():
        mesh["elements"] = [1, 1, 1]
    return data


def column(backend):
    """Square column, whose bending modes come in pairs of one frequency."""
    body = block(backend, [1.0, 1.0, 2.0], [0, 0, 0], [2, 2, 3], supports=[{"surface": "z_min"}])
    return alone(body, 0.3)


def mixed_pairing(a, b):
    data = blocks(a)
    data["bodies"]["lower"]["backend"] = b
    return data


def disc_pad(backend):
    """Disc and pad on few elements, on which the modes flutter late."""
    data = coarse("disc_pad", backend, {"pad": [2, 3, 1], "disc": [3, 24, 1]})
    method = {"fe": GRID, "iga": {"method": "segments"}}[backend]
    data["contacts"]["pad_disc"] |= {"formulation": method, "mu": 2.0}
    data["analysis"]["max_frequency"] = 6000.0
    return data


def saddle():
    """Eigenvalues and derivatives where some ranks have contact forces and no displacements.

    In the second scene each constraint is there once more, in another contact.
    """
    few = blocks("fe", mu=0.3) | {"analysis": {"kind": "cea", "max_frequency": 1.0}}
    for body in few["bodies"].values():
        body["mesh"]["fe"] |= {"elements": [1, 1, 1], "degree": 1}
    few["contacts"]["interface"] |= {"formulation": ONE_POINT, "form": "saddle"}
    twice = blocks("iga", "tied mortar", mu=0.3)
    twice["contacts"]["again"] = twice["contacts"]["interface"]
    modes = run_modes(read_scene(few), left=True).modes
    return {
        "im": modes.eigenvalues.imag.tolist(),
        "slopes": np.abs(modes.sensitivity("contacts.interface.mu")).tolist(),
        "tied twice": run_modes(checked(SECTIONS, twice)).modes.eigenvalues.imag.tolist(),
    }


def scenes():
    for backend in ("fe", "iga"):
        for contact in FORMULATIONS:
            yield f"{backend} {contact}", blocks(backend, contact)
            yield f"{backend} static {contact}", static(blocks(backend, contact))
        yield f"{backend} without friction", blocks(backend, mu=0.0)
        yield f"{backend} static without friction", static(blocks(backend, mu=0.0))
        yield f"{backend} overhanging", overhanging(blocks(backend))
        yield f"{backend} single point", static(single_point(backend))
        yield f"{backend} column", column(backend)
        yield f"{backend} disc_pad", disc_pad(backend)
    yield "several discs", two_blocks("fe", GRID, held=True, mu=2.0)
    yield "fe on iga", mixed_pairing("fe", "iga")
    yield "iga on fe", static(mixed_pairing("iga", "fe"))


CASES = tuple(name for name, _ in scenes())
"""Names of all cases."""


def probes(result):
    """Trace of each box at fixed points of its side x_max."""
    traces = {}
    for name, body in result.system.bodies.items():
        spec = result.scene.bodies[name].geometry
        if spec.shape != "box":
            continue
        inner = np.array([[1.0, y, z] for y in (0.13, 0.57) for z in (0.21, 0.83)])
        x = np.array(spec.origin) + inner * np.array(spec.size)
        found = body.surfaces["x_max"].locate(x, np.tile([1.0, 0.0, 0.0], (len(x), 1)), 1e-3)
        assert not found.missed.any()
        traces[name] = body.surfaces["x_max"].trace(found.at)
    return traces


def facts(scene):
    result = run_scene(scene)
    system, data = result.system, dict(result.data)
    matrices = [system.pencil().at().stiffness]
    matrices += [contact.K_n for contact in system.contacts if contact.has_pressure]
    matrices += [body.stiffness() for body in system.bodies.values()]
    matrices += [body.mass() for body in system.bodies.values() if system.with_mass]
    shown = {name: data.get(name) for name in ("contacts", "dofs", "stresses", "skipped")}
    shown["asymmetry"] = [asymmetry(matrix) for matrix in matrices]
    if result.spectrum is None:
        moved = [result.displacements(name, at).tolist() for name, at in probes(result).items()]
        shown["displacements"] = moved
        contact = system.contacts[0]
        if contact.has_pressure:
            pressure = contact.pressure(result.displacement)
            shown["closing force"] = float(contact.interface.points.weight @ pressure)
        return shown
    modes = result.modes
    shapes = [result.mode_shapes(name, trace) for name, trace in probes(result).items()]
    return shown | {
        "re": modes.growth_rates.tolist(),
        "im": modes.eigenvalues.imag.tolist(),
        "worst_residual": modes.residuals.max(),
        "count": [modes.window.found_below, modes.window.discs],
        "unstable": len(data["unstable"]),
        "shapes": np.moveaxis(np.abs(np.concatenate(shapes)), 2, 0).tolist() if shapes else [],
    }


SEARCHED = ("several discs", "iga gpts", "fe column", "iga column")
"""Cases that are searched in Krylov spaces."""


def case(name):
    """Facts of a case."""
    scene = read_scene(dict(scenes())[name])
    return (in_krylov_spaces(facts) if name in SEARCHED else facts)(scene)
