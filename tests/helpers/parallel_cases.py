"""Small scenes on any number of ranks: what must not depend on that number.

`case` runs one of `CASES`, `formulation` one of `FORMULATIONS` on coarse meshes of a scene that
comes with the project.
"""

import tomllib
from unittest.mock import patch

import numpy as np
from blocks import SECTIONS, block, two_blocks
from motions import asymmetry

from cea.eigen.krylov_schur import KrylovOptions
from scenes import run_modes, run_scene
from scenes.spec.plain import SCENES, checked
from scenes.spec.reading import read_scene

in_krylov_spaces = patch("cea.eigen.driver.KrylovOptions", lambda: KrylovOptions(dense_limit=0))
"""Small systems are searched like large ones, which ranks share: LAPACK would solve them whole."""
GRID, GPTS = {"method": "grid", "points": 5}, {"method": "gpts", "points": 4}


def blocks(backend, formulation, mu=1.0):
    """Two blocks that flutter, and few modes: each takes messages, slow where ranks share cores."""
    data = two_blocks(backend, formulation, held=True, mu=mu, P=30.0)
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
    data = blocks(backend, {"method": "gpts", "points": 1})
    for mesh in data["bodies"]["upper"]["mesh"].values():
        mesh["elements"] = [1, 1, 1]
    return data


def column(backend):
    """Square column, whose bending modes come in pairs of one frequency."""
    body = block(backend, [1.0, 1.0, 2.0], [0, 0, 0], [2, 2, 3], supports=[{"surface": "z_min"}])
    analysis = {"kind": "cea", "max_frequency": 0.3}
    return {"name": "column", "bodies": {"column": body}, "analysis": analysis}


def mixed_pairing(a, b):
    data = blocks(a, GPTS)
    data["bodies"]["lower"]["backend"] = b
    return data


def collocation(backend):
    """Collocation in the manner of the backend."""
    return {"method": {"fe": "node_to_surface", "iga": "greville"}[backend]}


def few_columns():
    """Fewer dofs than some rank needs to have any, beside multipliers on every rank."""
    data = blocks("fe", {"method": "gpts", "points": 1}, mu=0.3)
    for body in data["bodies"].values():
        body["mesh"]["fe"] |= {"elements": [1, 1, 1], "degree": 1}
    data["contacts"]["interface"]["form"] = "saddle"
    return data | {"analysis": {"kind": "cea", "max_frequency": 1.0}}


def tied_twice():
    """Constraints each of which is there once more, in another contact."""
    data = blocks("iga", {"method": "mortar"}, mu=0.3)
    first = data["contacts"]["interface"] | {"form": "saddle", "P": float("inf")}
    return data | {"contacts": {"interface": first, "again": first}}


def saddle():
    """Eigenvalues and derivatives where some ranks have contact forces and no displacements."""
    modes = run_modes(read_scene(few_columns()), left=True).modes
    slopes = modes.sensitivity("contacts.interface.mu")
    tied = run_modes(checked(SECTIONS, tied_twice())).modes
    return {
        "im": modes.eigenvalues.imag.tolist(),
        "slopes": np.abs(slopes).tolist(),
        "tied twice": tied.eigenvalues.imag.tolist(),
    }


def scenes():
    for backend in ("fe", "iga"):
        for formulation in (collocation(backend), GRID, GPTS):
            data = blocks(backend, formulation)
            yield f"{backend} {formulation['method']}", data
            yield f"{backend} {formulation['method']} static", static(data)
        yield f"{backend} without friction", blocks(backend, GPTS, mu=0.0)
        yield f"{backend} static without friction", static(blocks(backend, GPTS, mu=0.0))
        yield f"{backend} overhanging", overhanging(blocks(backend, GPTS))
        yield f"{backend} single point", static(single_point(backend))
        yield f"{backend} column", column(backend)
    yield "several discs", two_blocks("fe", GRID, held=True, mu=2.0)
    yield "fe on iga", mixed_pairing("fe", "iga")
    yield "iga on fe", static(mixed_pairing("iga", "fe"))


CASES = tuple(name for name, _ in scenes())
"""Names of all cases."""

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
COARSE = {
    "patch_test": {"upper": [3, 3, 1], "lower": [4, 4, 1]},
    "disc_pad": {"pad": [2, 3, 1], "disc": [3, 24, 1]},
}
"""Elements of the bodies of two scenes."""


def coarse(name, backend, **analysis):
    """A scene that comes with the project, on coarse meshes of quadratic elements."""
    data = tomllib.loads((SCENES / f"{name}.toml").read_text())
    for body, elements in COARSE[name].items():
        fe = {"cell": "hexahedron", "degree": 2, "elements": elements}
        mesh = {"fe": fe, "iga": {"degree": [2, 2, 2], "elements": elements}}
        data["bodies"][body] |= {"backend": backend, "mesh": mesh}
    data["analysis"] |= analysis
    return data


def formulation(scene, backend, name):
    """Displacements of the patch test, or eigenvalues of the disc and pad."""
    modes = scene == "disc_pad"
    data = coarse(scene, backend, **({"max_frequency": 6000.0} if modes else {"samples": 7}))
    (contact,) = data["contacts"].values()
    contact |= {"formulation": collocation(backend)} | FORMULATIONS[name]
    if modes:
        contact["mu"] = 2.0  # on coarse meshes the modes flutter late
    result = run_scene(read_scene(data))
    return eigenvalues(result) if modes else displacements(result)


def probes(result):
    """Trace of each body at fixed points of its side x_max."""
    traces = {}
    for name, body in result.system.bodies.items():
        spec = result.scene.bodies[name].geometry
        inner = np.array([[1.0, y, z] for y in (0.13, 0.57) for z in (0.21, 0.83)])
        x = np.array(spec.origin) + inner * np.array(spec.size)
        found = body.surfaces["x_max"].locate(x, np.tile([1.0, 0.0, 0.0], (len(x), 1)), 1e-3)
        assert not found.missed.any()
        traces[name] = body.surfaces["x_max"].trace(found.at)
    return traces


def facts(scene):
    result = run_scene(scene)
    system, data = result.system, dict(result.data)
    matrices = [system.pencil().at().stiffness, *(contact.K_n for contact in system.contacts)]
    matrices += [body.stiffness() for body in system.bodies.values()]
    matrices += [] if system.mass is None else [system.mass]
    shown = {name: data.get(name) for name in ("contacts", "dofs", "stresses", "skipped")}
    shown["asymmetry"] = [asymmetry(matrix) for matrix in matrices]
    if result.spectrum is None:
        weight = system.contacts[0].interface.points.weight
        force = float(weight @ system.contacts[0].pressure(result.displacement))
        return shown | {"displacements": displacements(result), "closing force": force}
    window = result.modes.window
    parts = [result.mode_shapes(name, trace) for name, trace in probes(result).items()]
    return {
        **shown,
        **eigenvalues(result),
        "count": [window.found_below, window.discs],
        "unstable": len(data["unstable"]),
        "shapes": np.moveaxis(np.abs(np.concatenate(parts)), 2, 0).tolist(),
    }


def displacements(result):
    """Displacements of each body at its probes."""
    return [result.displacements(name, trace).tolist() for name, trace in probes(result).items()]


def eigenvalues(result):
    """Eigenvalues alone."""
    modes = result.modes
    return {
        "re": modes.growth_rates.tolist(),
        "im": modes.eigenvalues.imag.tolist(),
        "worst_residual": modes.residuals.max(),
    }


SEARCHED = ("several discs", "iga gpts", "fe column", "iga column")
"""Cases that are searched in Krylov spaces."""


def case(name):
    """Facts of a case."""
    scene = read_scene(dict(scenes())[name])
    return (in_krylov_spaces(facts) if name in SEARCHED else facts)(scene)
